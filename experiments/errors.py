"""What a user of the command line can get wrong."""


class UsageError(ValueError):
    """An argument that names something that does not exist or cannot be; ends the command with code 2 and one line."""
