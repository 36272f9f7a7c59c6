"""The problem of [Zhakatayev2023]_ as the paper sets it: its motions, conditions and stages."""

from plantigrade.trajopt.tasks.task import BASES
from plantigrade.trajopt.zhakatayev2023.between_samples import Between, between
from plantigrade.trajopt.zhakatayev2023.body import PaperBody, paper_human
from plantigrade.trajopt.zhakatayev2023.formulation import PaperProblem, formulate
from plantigrade.trajopt.zhakatayev2023.motions import MOTIONS, PaperMotion, paper_task
from plantigrade.trajopt.zhakatayev2023.solve import PaperSolution, paper_motion
from plantigrade.trajopt.zhakatayev2023.staged import StageAttempt, StagedResult, solve_staged

__all__ = [
    "BASES",
    "MOTIONS",
    "Between",
    "PaperBody",
    "PaperMotion",
    "PaperProblem",
    "PaperSolution",
    "StageAttempt",
    "StagedResult",
    "between",
    "formulate",
    "paper_human",
    "paper_motion",
    "paper_task",
    "solve_staged",
]
