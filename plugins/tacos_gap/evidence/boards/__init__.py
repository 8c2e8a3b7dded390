"""Boards: what is seen of flat targets, less what their poses, their paper and an unstated lens explain."""

from tacos_gap.evidence.boards.detection import find_corners
from tacos_gap.evidence.boards.evidence import BoardEvidence, evidence_of_boards
from tacos_gap.evidence.boards.folders import boards_found
from tacos_gap.evidence.boards.hidden import hidden_by_pose
from tacos_gap.evidence.boards.tracing import source_of

__all__ = [
    "BoardEvidence",
    "boards_found",
    "evidence_of_boards",
    "find_corners",
    "hidden_by_pose",
    "source_of",
]
