"""What a user of the command line can get wrong."""


class UsageError(ValueError):
    """An argument that names something that does not exist or cannot be; ends the command with code 2 and one line."""


class ExperimentsFailedError(RuntimeError):
    """An experiment has no result, so that a figure over all of them would be of others than were asked for."""
