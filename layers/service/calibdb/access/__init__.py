"""Access: API tokens, session tickets, plans and quotas."""
