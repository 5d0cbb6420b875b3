"""The operator's commands: each reads its options, has the work done, and prints what came out.

A command imports its module when it runs: only then are the layers on the path, and some modules load slowly
(the solver, pyarrow).
"""
