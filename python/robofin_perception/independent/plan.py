"""Which pictures a set has: workpiece, placement, state of the coating, split."""

from dataclasses import asdict, dataclass
from random import Random
from typing import Any

from .source import SourceSet

SPLITS = ("train", "validation", "test")
TRAIN_SHARE, VALIDATION_SHARE = 0.4, 0.1
STATES = 6
"""Pictures of a placement at most; one in as many is unsanded or bare, in turn, and the others are stages of paths."""


@dataclass(frozen=True)
class Treatment:
    """State of the coating; pattern and stage are set if it is a stage of a path."""

    kind: str
    pattern: str | None = None
    stage: int | None = None

    @property
    def name(self) -> str:
        """As in the names of pictures, for example `spiral-s2`."""
        return f"{self.pattern}-s{self.stage}" if self.kind == "stage" else self.kind

    def record(self) -> dict[str, Any]:
        """As in the program's metadata."""
        return {key: value for key, value in asdict(self).items() if value is not None}


@dataclass(frozen=True)
class Planned:
    """A picture to render."""

    id: str
    workpiece: str
    placement: int
    treatment: Treatment
    split: str


@dataclass(frozen=True)
class Shares:
    """Pictures of each placement, and the split of all of them; without one, placements are divided among splits."""

    states: int = STATES
    split: str | None = None


def plan(source: SourceSet, count: int, seed: int, shares: Shares) -> list[Planned]:
    """The pictures of a set: placements take turns among workpieces, and each shows several states."""
    random = Random(f"{seed}/plan")
    cycle = min(STATES - 1, len(source.patterns) * source.stages) + 1
    states = min(shares.states, cycle)
    rounds = -(-count // (states * len(source.workpieces)))
    splits = {name: split_of_placements(rounds, random) for name in source.workpieces}
    treatments = {name: deal(source, rounds, (states, cycle), random) for name in source.workpieces}
    pictures = [
        Planned(f"{name}-p{place:02}-{treatment.name}", name, place, treatment, shares.split or splits[name][place])
        for place in range(rounds)
        for name in source.workpieces
        for treatment in treatments[name][place]
    ]
    return pictures[:count]


def split_of_placements(count: int, random: Random) -> list[str]:
    """The split of each placement, in the shares of the set, in random order."""
    train, validation = round(TRAIN_SHARE * count), round(VALIDATION_SHARE * count)
    splits = ["train"] * train + ["validation"] * validation + ["test"] * (count - train - validation)
    random.shuffle(splits)
    return splits


def deal(source: SourceSet, placements: int, states: tuple[int, int], random: Random) -> list[list[Treatment]]:
    """The states of each placement; every stage of every pattern is used once before one is used again.

    `states` are those of a placement, and those of which one is unsanded or bare.
    """
    stages = [
        Treatment("stage", pattern, stage) for pattern in source.patterns for stage in range(1, source.stages + 1)
    ]
    ends = [Treatment("unsanded"), Treatment("bare")]
    each, cycle = states
    deck: list[Treatment] = []
    hands = []
    for placement in range(placements):
        before, after = placement * each // cycle, (placement + 1) * each // cycle
        sanded = each - (after - before)
        if len(deck) < sanded:
            random.shuffle(stages)
            deck = [stage for stage in stages if stage not in deck] + deck
        hand = [deck.pop() for _ in range(sanded)]
        if after > before:
            hand.insert(random.randrange(len(hand) + 1), ends[before % 2])
        hands.append(hand)
    return hands
