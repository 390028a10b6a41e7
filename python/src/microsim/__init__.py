"""Sessions and results of MicroSim, for statistics: readers alone, with the standard library alone."""

from .attempt import Attempt
from .session import Ending, Frame, Message, NotASession, Session, attempts_in
from .statistics import Comparison, Cusum, compare, cusum
from .store import NotAStore, Store, Trainee, default_store

__all__ = [
    "Attempt",
    "Comparison",
    "Cusum",
    "Ending",
    "Frame",
    "Message",
    "NotASession",
    "NotAStore",
    "Session",
    "Store",
    "Trainee",
    "attempts_in",
    "compare",
    "cusum",
    "default_store",
]
