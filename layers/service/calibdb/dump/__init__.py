"""Public dumps of the database: what is given away, in parts, with statistics."""
