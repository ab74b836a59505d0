"""The one error that a person made: bad input, told in one sentence."""


class InputError(ValueError):
    """Input that cannot be used.

    The message is one sentence that names the file and the key or topic, what was found, what was expected and, where
    it helps, what to do. The command line prints it and exits with status 2.
    """
