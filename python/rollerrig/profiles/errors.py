"""The one exception of this package: a profile that cannot be used, and why."""


class ProfileError(ValueError):
    """A profile was asked for or read that has no usable shape.

    The message says where, what was found, what is allowed and, where one can guess, the likely fix.
    """
