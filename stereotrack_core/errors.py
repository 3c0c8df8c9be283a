"""Errors that a person reads: what is wrong, where, and what to do about it."""


class InputError(Exception):
    """Something that the user gave us is wrong.

    Parameters
    ----------
    what : str
        What is wrong, as a clause without a full stop.
    where : str, optional
        File and key, or option, in which it is wrong.
    remedy : str, optional
        What would be right.
    """

    def __init__(self, what: str, *, where: str = "", remedy: str = "") -> None:
        self.what = what
        self.where = where
        self.remedy = remedy
        sentence = f"{where}: {what}" if where else what
        super().__init__(f"{sentence}. {remedy}".strip() if remedy else sentence)


class Cancelled(Exception):
    """Long work was stopped on request; what was finished before is kept."""
