"""Errors that a user can fix, reported in one line."""


class UserError(Exception):
    """An error that the user can fix; the message says what is wrong, where, what is allowed and how to fix it."""
