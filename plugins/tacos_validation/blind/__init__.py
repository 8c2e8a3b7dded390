"""The diagnosis checked on effects that were withheld from it."""
