"""Random histories of a database, with a solver that takes no time."""

import functools
import hashlib
import random
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import calibsolver.consensus
from calibdb import schema
from calibdb.camera_key import camera_key
from calibdb.store.names import with_current_key
from calibsolver.fitting.coverage import Coverage
from infra.local import LocalStack
from infra.ops import withdrawal
from infra.ops.context import OpsContext
from infra.ops.reindex import reindex
from tests.helpers.service.client import EDGE, Truth
from tests.helpers.service.edge import Question, questions
from tests.helpers.service.known import LENS
from tests.helpers.service.published import asked, calibration, held, mode_of

PLATFORMS = ("X11; Linux x86_64", "Windows NT 10.0; Win64; x64", "Linux; Android 14; Pixel 8")
#: one name with two USB ids and without one, and a name that many cameras have
LABELS = ("Webcam Z77 (1111:0001)", "Webcam Z77 (1111:0002)", "Webcam Z77", "Integrated Camera (2222:0003)")
SPELLINGS = ("WEBCAM Z77 (1111:0001)", "Webcam Z77 (1111:0009)", "Integrated Camera")
SIZES = ((1280, 720), (640, 360))
QUESTIONS = questions((*LABELS, *SPELLINGS), PLATFORMS, SIZES)
#: a person's own database, and one of strangers
RULES = (
    {"MIN_CALIBRATIONS": "2", "MIN_CONTRIBUTORS": "1", "CONTRIBUTOR_PERIOD": "0", "MIN_VOTES": "1"},
    {"MIN_CALIBRATIONS": "2", "MIN_CONTRIBUTORS": "2", "CONTRIBUTOR_PERIOD": "86400", "MIN_VOTES": "1"},
)
MODELS = {
    "rectilinear": LENS,
    "fisheye": (0.0,) * 4,
    "rational": (*LENS, 0.0, 0.0, 0.0),
    "omnidirectional": LENS,
}
STEPS = (
    ("publish",) * 5 + ("look up",) * 6 + ("withdraw",) * 3 + ("restore",) * 2 + ("vote", "forget", "reindex")
)


@functools.cache
def documents() -> tuple[schema.CalibrationDocument, ...]:
    """Three calibrations of each camera at one size and one at another."""
    found = []
    for label in LABELS:
        for n in range(4):
            one = calibration(label, n, views=3)
            size = SIZES[n == 3]
            found.append(
                one.model_copy(update={"img_size": size, "platform": PLATFORMS[n % 2]})
                if identifiable(label)
                else one.model_copy(update={"img_size": size})
            )
    return tuple(found)


def identifiable(label: str) -> bool:
    return camera_key(label, PLATFORMS[0]) == camera_key(label, PLATFORMS[1])


def pool(members: Any, img_size: tuple[int, int], model: str, rule: Any) -> SimpleNamespace:
    """A consensus that differs with its members, and is reliable when there are enough."""
    ids = sorted(member.id for member in members)
    contributors = len({member.contributor for member in members})
    enough = len(ids) >= rule.min_calibrations
    reason = None if enough else "too_few"
    if enough and contributors < rule.min_contributors:
        reason = "few_contributors"
    f = 900 + int(hashlib.sha256(repr((ids, model)).encode()).hexdigest()[:4], 16) / 655
    record = {
        "img_size": img_size,
        "camera_matrix": ((f, 0, img_size[0] / 2), (0, f, img_size[1] / 2), (0, 0, 1)),
        "distortion_coefficients": MODELS[model],
        "distortion_model": model,
        "avg_reprojection_error": 0.2,
        "uncertainty": {"rms": 0.2, "max": 0.5},
    }
    return SimpleNamespace(
        calibration=SimpleNamespace(record=lambda: record),
        coverage=Coverage(0.6, 0.2),
        members=tuple(ids),
        contributors=contributors,
        reliable=reason is None,
        reason=reason,
        consistent=contributors >= rule.min_contributors,
        spread=0.3,
        held_out_error=0.3,
        groups=(tuple(ids),),
        member_errors=dict.fromkeys(ids, 0.2),
    )


_SOLVER = calibsolver.consensus.pool
_users = 0  # of the quick solver, in whatever order they end


@contextmanager
def quick_solver() -> Iterator[None]:
    """Pool without fitting for a while; the last user brings the solver back."""
    global _users
    _users += 1
    calibsolver.consensus.pool = pool  # type: ignore[assignment]
    try:
        yield
    finally:
        _users -= 1
        if not _users:
            calibsolver.consensus.pool = _SOLVER


class History:
    """A stack to which random things happen."""

    def __init__(self, stack: LocalStack, seed: int) -> None:
        self.stack = stack
        self.rng = random.Random(seed)
        self.context = OpsContext.of(stack.environment, secret_known=True, echo=lambda _: None)
        self.done: list[str] = []
        for document in documents():
            if document.camera in self.rng.sample(LABELS, 2):
                self.publish(document)
        stack.wait_until_idle(60)

    def step(self) -> None:
        """Let one thing happen, until it is acknowledged."""
        what = self.rng.choice(STEPS)
        document = self.rng.choice(documents())
        self.done.append(f"{what} {document.camera} {document.id[-6:]}")
        getattr(self, what.replace(" ", "_"))(document)

    def publish(self, document: schema.CalibrationDocument) -> None:
        """As submit does."""
        self.context.store.calibrations.publish(document)
        self.context.store.refit.later(asked(mode_of(document)))

    def look_up(self, _: schema.CalibrationDocument) -> None:
        question: Question = self.rng.choice(list(QUESTIONS.values()))
        question.ask(self.stack, address=f"192.0.2.{self.rng.randrange(2)}")

    def withdraw(self, document: schema.CalibrationDocument) -> None:
        if self.context.store.calibrations.get(document.id):
            withdrawal.withdraw(self.context, document.id, "wrong")

    def restore(self, document: schema.CalibrationDocument) -> None:
        if self.context.store.calibrations.withdrawal(document):
            withdrawal.restore(self.context, document.id)

    def vote(self, document: schema.CalibrationDocument) -> None:
        """As checks does."""
        seen = held(Truth(seed=self.rng.randrange(9)), 3)
        views = tuple(schema.ViewDocument(index=i, ids=a, points=b) for i, (a, b) in enumerate(seen))
        source = f"voter {self.rng.randrange(3)}"
        name = f"6553f1{self.rng.randrange(16**14):014x}"
        changed = {"id": name, "views": views, "source": source, "time": document.time + 3600}
        cast = {**document.model_dump(exclude={"fits"}), **changed}
        self.context.store.votes.cast(schema.VoteDocument(**cast, noise=0.2))
        self.context.store.refit.now(asked(mode_of(with_current_key(document)), "rectilinear"))

    def forget(self, document: schema.CalibrationDocument) -> None:
        withdrawal.forget(self.context, {document.contributor})

    def reindex(self, _: schema.CalibrationDocument | None = None) -> None:
        reindex(self.context)


@contextmanager
def history(seed: int) -> Iterator[History]:
    rules = RULES[seed % len(RULES)]
    with quick_solver(), LocalStack(environment={**rules, "EDGE_SECRETS": EDGE}) as stack:
        yield History(stack, seed)
