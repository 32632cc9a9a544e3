"""The one exception of this package: an irregularity that cannot be used, and why."""


class IrregularityError(ValueError):
    """A file of measured rails that cannot be used; the message says where, what was found and what is allowed."""
