"""What is hung on a structure whose modes are all known has the effect that its matrices say."""

from collections.abc import Callable

import numpy as np
import pytest
from chain import BARE, OTHER, Chain
from scipy import linalg

from modallab.core.errors import DataError
from modallab.formats.frf_file import rig_without_places
from modallab.modification.attachments import AttachedPart, Element, RigidLink, TunedAbsorber
from modallab.modification.coupled import CouplingToStructure
from modallab.modification.inverse import By, best_absorber, changes_for_free_band, changes_for_frequency
from modallab.modification.known import KnownStructure
from modallab.modification.modified import passive_damping
from modallab.modification.remainder import pole_intervals_of_remainder
from modallab.modification.structure import structure_of
from modallab.reporting.modification_table import modified_rows

HZ = np.linspace(5.0, 60.0, 40)
S = 2j * np.pi * HZ


def with_matrices(mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray) -> Chain:
    """The chain with more on its matrices."""
    return Chain(BARE.mass + mass, BARE.damping + damping, BARE.stiffness + stiffness)


def at(*entries: tuple[int, int, float]) -> np.ndarray:
    """A matrix of few entries, points from 1."""
    found = np.zeros((4, 4))
    for i, j, value in entries:
        found[i - 1, j - 1] += value
    return found


NONE = np.zeros((4, 4))
BETWEEN = [(2, 2, 1.0), (4, 4, 1.0), (2, 4, -1.0), (4, 2, -1.0)]


@pytest.mark.parametrize(
    ("changes", "truth"),
    [
        ([Element(3, mass=0.4)], with_matrices(at((3, 3, 0.4)), NONE, NONE)),
        ([Element(3, mass=-0.4)], with_matrices(at((3, 3, -0.4)), NONE, NONE)),
        ([Element(2, spring=2e4)], with_matrices(NONE, NONE, at((2, 2, 2e4)))),
        ([Element(2, damper=30.0)], with_matrices(NONE, at((2, 2, 30.0)), NONE)),
        ([Element(2, 4, spring=2e4)], with_matrices(NONE, NONE, 2e4 * at(*BETWEEN))),
        (
            [Element(3, mass=0.4), Element(2, 4, spring=2e4, damper=3.0), Element(1, damper=5.0)],
            with_matrices(at((3, 3, 0.4)), 3.0 * at(*BETWEEN) + at((1, 1, 5.0)), 2e4 * at(*BETWEEN)),
        ),
    ],
    ids=["mass", "mass removed", "spring", "damper", "spring between", "several"],
)
def test_elements_change_poles_and_frfs_as_their_matrices_say(changes: list[AttachedPart], truth: Chain) -> None:
    after = KnownStructure(BARE.model()).with_changes(changes)
    expected = truth.poles()
    np.testing.assert_allclose(after.modes.frequency_hz, np.abs(expected) / (2 * np.pi), rtol=1e-9)
    np.testing.assert_allclose(after.modes.damping_ratio, -expected.real / np.abs(expected), rtol=1e-6)
    np.testing.assert_allclose(after.structure_with_parts.receptance(S), truth.receptance(S), rtol=1e-8, atol=1e-16)


def test_shapes_after_a_change_give_its_frfs_again() -> None:
    truth = with_matrices(at((3, 3, 0.4)), NONE, NONE)
    modes = KnownStructure(BARE.model()).with_changes([Element(3, mass=0.4)]).modes
    poles = 2 * np.pi * modes.frequency_hz * (-modes.damping_ratio + 1j * np.sqrt(1 - modes.damping_ratio**2))
    pairs = np.einsum("ro,ri->roi", modes.psi, modes.psi)
    again = np.einsum("lr,roi->loi", 1 / (S[:, None] - poles), pairs)
    again += np.einsum("lr,roi->loi", 1 / (S[:, None] - poles.conj()), pairs.conj())
    np.testing.assert_allclose(again, truth.receptance(S), rtol=1e-6, atol=1e-14)


def test_an_absorber_adds_a_mode_and_splits_the_one_it_is_tuned_to() -> None:
    absorber = TunedAbsorber(2, 0.1, 20.0, 0.05)
    mass, damping, stiffness = (np.zeros((5, 5)) for _ in range(3))
    for whole, part in ((mass, BARE.mass), (damping, BARE.damping), (stiffness, BARE.stiffness)):
        whole[:4, :4] = part
    mass[4, 4] = 0.1
    pair = np.ix_([1, 4], [1, 4])
    damping[pair] += absorber.damper * np.array([[1, -1], [-1, 1]])
    stiffness[pair] += absorber.spring * np.array([[1, -1], [-1, 1]])
    truth = Chain(mass, damping, stiffness).poles()
    modes = KnownStructure(BARE.model()).with_changes([absorber]).modes
    np.testing.assert_allclose(modes.frequency_hz, np.abs(truth) / (2 * np.pi), rtol=1e-9)
    np.testing.assert_allclose(modes.damping_ratio, -truth.real / np.abs(truth), rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "ties"),
    [(RigidLink(2), [[0, 1, 0, 0]]), (RigidLink(1, 4), [[1, 0, 0, -1]])],
    ids=["ground", "rigid link"],
)
def test_a_rigid_link_takes_a_motion_away(change: AttachedPart, ties: list[list[int]]) -> None:
    free = linalg.null_space(np.array(ties, float))
    truth = Chain(*(free.T @ m @ free for m in (BARE.mass, BARE.damping, BARE.stiffness)))
    modes = KnownStructure(BARE.model()).with_changes([change]).modes
    np.testing.assert_allclose(modes.frequency_hz, np.abs(truth.poles()) / (2 * np.pi), rtol=1e-9)


@pytest.mark.parametrize("joint", [None, 3e4])
def test_two_structures_coupled_are_one_and_taken_apart_again_are_two(joint: float | None) -> None:
    whole = [linalg.block_diag(a, b) for a, b in zip(_matrices(BARE), _matrices(OTHER), strict=True)]
    apart = np.array([[0.0, 0.0, 0.0, 1.0, -1.0, 0.0]])
    if joint is None:
        free = linalg.null_space(apart)
        truth = Chain(*(free.T @ m @ free for m in whole))
    else:
        truth = Chain(whole[0], whole[1], whole[2] + joint * apart.T @ apart)
    other = structure_of(OTHER.model())
    both = KnownStructure(BARE.model()).with_changes([CouplingToStructure(other, [(4, 1)], joint)])
    np.testing.assert_allclose(both.modes.frequency_hz, np.abs(truth.poles()) / (2 * np.pi), rtol=1e-8)
    again = both.with_changes([CouplingToStructure(other, [(4, 1)], joint, sign=-1)]) if joint is None else None
    if again is not None:
        np.testing.assert_allclose(both.structure_with_parts.receptance(S)[:, 3, 3], _parallel(S), rtol=1e-8)


@pytest.mark.parametrize("gain", [1.0, 1.01])
def test_a_measured_part_taken_away_leaves_the_rest_and_no_pole_of_its_antiresonances(gain: float) -> None:
    part = OTHER.model()
    part = part.model_copy(update={"modal_constants": gain * part.modal_constants})
    unsure = KnownStructure(part.model_copy(update={"modal_constant_sigma": 0.01 * np.abs(part.modal_constants)}))
    taken = CouplingToStructure(unsure.structure, [(4, 1)], sign=-1, samples=unsure.samples)
    both = _joined(OTHER).model()
    on_it = {"outputs": both.outputs[:4], "output_points": (1, 2, 3, 4), "residuals": both.residuals[:, :4]}
    arrays = {name: getattr(both, name)[:, :4] for name in ("modal_constants", "modal_constant_sigma")}
    rest = KnownStructure(both.model_copy(update=on_it | arrays)).with_changes([taken])
    near = 1e-6 if gain == 1 else 3e-3
    truth = np.abs(BARE.poles()) / (2 * np.pi)
    np.testing.assert_allclose(rest.modes.frequency_hz, truth, rtol=near)
    np.testing.assert_array_less(
        np.abs(rest.modes.frequency_hz - truth), 1e-6 * truth + 3 * rest.modes.frequency_sigma_hz
    )
    if gain == 1:
        frf = rest.frf(HZ, [2], [4], quantity="receptance").values[0, 0]
        np.testing.assert_allclose(frf, BARE.receptance(S)[:, 1, 3], rtol=1e-4)


def test_errors_at_a_joint_grow_by_what_the_two_receptances_cancel() -> None:
    bare, other, low_high = KnownStructure(BARE.model()), structure_of(OTHER.model()), BARE.model().band_hz
    s = 2j * np.pi * np.linspace(*low_high, 201)[1:]
    h, y = BARE.receptance(s)[:, 3, 3], OTHER.receptance(s)[:, 0, 0]
    assert bare.with_changes([Element(3, mass=0.1)]).conditioning is None
    for sign in (1, -1):
        grown = np.median((np.abs(h) + np.abs(y)) / np.abs(h + sign * y))
        found = bare.with_changes([CouplingToStructure(other, [(4, 1)], sign=sign)])
        np.testing.assert_allclose(found.conditioning, grown, rtol=1e-6)


def test_two_joints_that_move_apart_grow_errors_as_the_worse_of_them() -> None:
    """Whatever the units of one of them are."""
    springs = Chain(np.eye(4), np.zeros((4, 4)), np.diag([1e4, 1e8, 1e4, 1e4]))
    part = structure_of(Chain(np.eye(2), np.zeros((2, 2)), np.diag([2e4, 2e8])).model())
    alone = [
        KnownStructure(springs.model()).with_changes([CouplingToStructure(part, [(n, n)])]).conditioning for n in (1, 2)
    ]
    both = KnownStructure(springs.model()).with_changes([CouplingToStructure(part, [(1, 1), (2, 2)])]).conditioning
    assert None not in alone
    assert both is not None
    assert max(alone) <= both * (1 + 1e-9)


def test_modes_of_the_rest_lie_between_those_of_both() -> None:
    """A change of rank one: modes of the two apart and those of both take turns."""
    low, high = pole_intervals_of_remainder(structure_of(_joined(OTHER).model()), structure_of(OTHER.model())).T
    own = np.sort(BARE.poles().imag)
    assert np.all((low < own) & (own <= high))


def test_a_table_says_that_what_nearly_makes_the_whole_is_not_to_be_taken_away() -> None:
    heavy = Chain(50 * OTHER.mass, 50 * OTHER.damping, 50 * OTHER.stiffness)
    said = []
    for part in (OTHER, heavy):
        joined = KnownStructure(_joined(part).model())
        rest = joined.with_changes([CouplingToStructure(structure_of(part.model()), [(4, 1)], sign=-1)])
        said.append(modified_rows(rest, []).caption)
    assert ["Do not use" in caption for caption in said] == [False, True]


def test_what_is_coupled_brings_its_own_uncertainty() -> None:
    bare = KnownStructure(BARE.model())
    unsure = KnownStructure(OTHER.model().model_copy(update={"frequency_sigma_hz": np.full(2, 0.05)}))
    one = bare.with_changes([CouplingToStructure(unsure.structure, [(4, 1)], samples=unsure.samples)])
    other = unsure.with_changes([CouplingToStructure(bare.structure, [(1, 4)], samples=bare.samples)])
    assert one.modes.frequency_sigma_hz.max() > 1e-3
    np.testing.assert_allclose(one.modes.frequency_sigma_hz, other.modes.frequency_sigma_hz, rtol=1e-6)
    variance = one.frf(HZ, [4], [4]).variance, other.frf(HZ, [1], [1]).variance
    np.testing.assert_allclose(variance[0], variance[1], rtol=1e-6)


def test_a_root_that_is_met_to_the_last_digit_stays() -> None:
    model = BARE.model()
    unsure = KnownStructure(model.model_copy(update={"frequency_sigma_hz": 1e-3 * model.frequency_hz}))
    sigmas = [
        unsure.with_changes([Element(3, mass=mass)]).modes.frequency_sigma_hz for mass in 0.4 + 1e-4 * np.arange(8)
    ]
    np.testing.assert_allclose(sigmas, np.broadcast_to(sigmas[0], np.shape(sigmas)), rtol=1e-2)


def test_what_is_uncertain_of_two_structures_has_nothing_in_common() -> None:
    drawn = []
    for chain in (BARE, OTHER, BARE):
        model = chain.model()
        model = model.model_copy(update={"frequency_sigma_hz": 0.01 * model.frequency_hz})
        drawn.append(KnownStructure(model).samples.poles[:, 0].imag)
    assert abs(np.corrcoef(drawn[0], drawn[1])[0, 1]) < 0.3
    np.testing.assert_array_equal(drawn[0], drawn[2])


def test_a_mode_that_one_hit_made_is_as_uncertain_as_one_hit() -> None:
    model = BARE.model()
    rig = rig_without_places(model.outputs, model.output_points, model.input_points, "inertance")
    tolerance = rig.tolerance.model_copy(update={"sensitivity": 0.0, "hit_gain": 0.01})
    shares = np.full((model.n_modes, len(model.input_points), 4), 0.25)
    shares[1] = np.array([1.0, 0.0, 0.0, 0.0])
    known = KnownStructure(
        model.model_copy(update={"hit_shares": shares}), rig.model_copy(update={"tolerance": tolerance})
    )
    at = model.input_points[0] - 1
    constants = known.samples.psi[:, :, at] ** 2
    off = np.std(np.abs(constants), axis=0) / np.abs(constants.mean(axis=0))
    np.testing.assert_allclose(off[:2], [0.005, 0.01], rtol=0.15)


def test_frfs_without_residual_terms_are_those_of_the_modes() -> None:
    held = BARE.model()
    more = held.model_copy(
        update={"residuals": 1e-6 * np.ones((1, 4, len(held.input_points))), "residual_powers": (0,)}
    )
    alone, known = KnownStructure(held), KnownStructure(more)
    added = [Element(3, mass=0.4)]
    for one, other in ((known, alone), (known.with_changes(added), alone.with_changes(added))):
        bare, expected = one.without_residual_terms.frf(HZ).values, other.frf(HZ).values
        np.testing.assert_allclose(bare, expected, rtol=1e-9)
        assert not np.allclose(one.frf(HZ).values, expected, rtol=1e-3)


def _matrices(chain: Chain) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return chain.mass, chain.damping, chain.stiffness


def _joined(part: Chain) -> Chain:
    """The chain with a part held to its last point."""
    whole = [np.zeros((5, 5)) for _ in range(3)]
    for both, a, b in zip(whole, _matrices(BARE), _matrices(part), strict=True):
        both[:4, :4] += a
        both[3:, 3:] += b
    return Chain(*whole)


def _parallel(s: np.ndarray) -> np.ndarray:
    """Receptance of two structures held together at one point each."""
    return 1 / (1 / BARE.receptance(s)[:, 3, 3] + 1 / OTHER.receptance(s)[:, 0, 0])


def test_what_is_added_and_taken_away_again_is_no_change() -> None:
    bare = BARE.model()
    again = KnownStructure(bare).with_changes([Element(3, mass=0.4)]).with_changes([Element(3, mass=-0.4)])
    np.testing.assert_allclose(again.modes.frequency_hz, bare.frequency_hz, rtol=1e-10)


@pytest.mark.parametrize("mass", [100.0, 1e3])
def test_a_heavy_mass_on_what_lies_outside_the_band_is_a_mode_more(mass: float) -> None:
    """Three modes of eight hardly move a point near the clamp; the static compliance of the others carries the mass."""
    chain, kept = Chain.of([1.0] * 8, [1e5, *[1e4] * 7, 1e-3], damping=1e-6), 3
    whole = chain.model(driven=tuple(range(1, 9)))
    high = float(np.sqrt(np.prod(whole.frequency_hz[kept - 1 : kept + 1])))
    outside = whole.modal_constants[kept:].real / (2 * np.pi * whole.frequency_hz[kept:, None, None]) ** 2
    names = (
        "frequency_hz", "damping_ratio", "frequency_sigma_hz", "damping_sigma", "modal_constants",
        "modal_constant_sigma", "half_power", "half_power_floor",
    )  # fmt: skip
    cut = {name: getattr(whole, name)[:kept] for name in names}
    cut |= {"band_hz": (0.1, high), "residual_powers": (0,), "residuals": outside.sum(axis=0)[None]}
    found = KnownStructure(whole.model_copy(update=cut)).with_changes([Element(1, mass=mass)]).modes.frequency_hz
    added = np.zeros((8, 8))
    added[0, 0] = mass
    truth = np.abs(Chain(chain.mass + added, chain.damping, chain.stiffness).poles()) / (2 * np.pi)
    np.testing.assert_allclose(found, truth[truth < high], rtol=0.01)


def test_a_mass_at_a_node_of_a_mode_leaves_it_alone() -> None:
    even = Chain.of([1.0, 1.0, 1.0], [1e4] * 4)
    modes = KnownStructure(even.model()).with_changes([Element(2, mass=0.5)]).modes
    np.testing.assert_allclose(modes.frequency_hz[1], even.model().frequency_hz[1], rtol=1e-9)
    np.testing.assert_allclose(modes.psi[1, 1], 0, atol=1e-8)


def test_a_model_without_a_driving_point_knows_measured_pairs_and_says_how_to_get_the_others() -> None:
    blind = KnownStructure(BARE.model().model_copy(update={"output_points": (11, 12, 13, 14)}))
    found = blind.frf(HZ, [12, 14], [1], "receptance", sigma=False).values[:, 0].T
    np.testing.assert_allclose(found, BARE.receptance(S)[:, [1, 3], 0], rtol=1e-9)
    for of_all in (lambda: blind.frf(HZ, [12], [14]), lambda: blind.with_changes([Element(12, mass=0.1)])):
        with pytest.raises(DataError, match="hit once at a point that has a sensor"):
            of_all()


@pytest.mark.parametrize(("name", "there"), [("mass", BARE.mass), ("spring", BARE.stiffness)])
def test_no_more_can_be_taken_away_than_there_is(name: str, there: np.ndarray) -> None:
    # At a point there is what leaves the matrix positive definite.
    most, known = 1 / np.linalg.inv(there)[2, 2], KnownStructure(BARE.model())
    assert known.with_changes([Element(3, **{name: -0.99 * most})]).modes.frequency_hz.size
    with pytest.raises(DataError, match="more than the structure has there"):
        known.with_changes([Element(3, **{name: -1.01 * most})])


def test_a_point_that_the_model_does_not_know_is_named_with_those_it_knows() -> None:
    with pytest.raises(DataError, match="1, 2, 3, 4"):
        KnownStructure(BARE.model()).with_changes([Element(9, mass=0.1)])


@pytest.mark.parametrize(
    ("kind", "numbers"),
    [
        (Element, {"at": 1}),
        (Element, {"at": 1, "to": 2, "mass": 0.1}),
        (Element, {"at": 1, "mass": np.nan}),
        (TunedAbsorber, {"at": 1, "mass": 0, "frequency_hz": 5}),
    ],
)
def test_a_change_that_is_none_is_rejected(kind: Callable[..., AttachedPart], numbers: dict[str, float]) -> None:
    with pytest.raises(DataError):
        kind(**numbers)


@pytest.mark.parametrize(("by", "to_hz"), [("mass", 10.5), ("spring", 14.0)])
def test_the_size_that_brings_a_mode_to_a_frequency_does_so(by: By, to_hz: float) -> None:
    known = KnownStructure(BARE.model())
    for answer in changes_for_frequency(known, 1, to_hz, by, [1, 2, 3]):
        assert answer.feasible
        after = known.with_changes([Element(answer.at, **{by: answer.size})]).modes
        np.testing.assert_allclose(after.frequency_hz[0], to_hz, rtol=1e-8)
        assert answer.hz_sigma == pytest.approx(after.frequency_sigma_hz[0])


def test_a_frequency_out_of_reach_has_no_answer_and_says_what_is_in_reach() -> None:
    """No spring to ground brings a mode beyond the next one of the structure held there."""
    held = np.delete(np.delete(BARE.stiffness, 1, 0), 1, 1), np.delete(np.delete(BARE.mass, 1, 0), 1, 1)
    limit = float(np.sqrt(linalg.eigh(*held, eigvals_only=True)[0]) / (2 * np.pi))
    (answer,) = changes_for_frequency(KnownStructure(BARE.model()), 1, 1.05 * limit, "spring", [2])
    assert not answer.feasible
    assert 0.9 * limit < answer.highest_hz < limit


def test_the_best_absorber_of_a_structure_of_one_mode_is_den_hartogs() -> None:
    one = KnownStructure(Chain.of([2.0], [1e4, 0.0], damping=1e-9).model())
    absorber, found_ratio, before, after, *_ = best_absorber(one, 1, 1, 0.1)
    ratio, own = 0.05, float(np.sqrt(1e4 / 2) / (2 * np.pi))
    assert found_ratio == pytest.approx(ratio)
    # Of the mobility the best tuning lies between those of receptance and inertance, 1 / (1 + mu) and 1 / sqrt(1 + mu).
    assert 1 / (1 + ratio) < absorber.frequency_hz / own < 1 / np.sqrt(1 + ratio)
    np.testing.assert_allclose(absorber.damping_ratio, np.sqrt(3 * ratio / (8 * (1 + ratio))), rtol=0.05)
    assert after < 0.01 * before


@pytest.mark.parametrize("links", [[RigidLink(2), RigidLink(2)], [RigidLink(3, 3)]], ids=["twice", "to itself"])
def test_rigid_links_that_hold_one_motion_twice_are_rejected(links: list[RigidLink]) -> None:
    with pytest.raises(DataError, match="hold one motion twice"):
        KnownStructure(BARE.model()).with_changes(links)


def test_a_structure_held_everywhere_has_no_mode() -> None:
    assert not KnownStructure(BARE.model()).with_changes([RigidLink(p) for p in (1, 2, 3, 4)]).modes.frequency_hz.size


@pytest.mark.parametrize("by", ["mass", "spring"])
def test_the_smallest_size_that_frees_a_band_does_so_and_less_does_not(by: By) -> None:
    known = KnownStructure(BARE.model())
    hz = known.modes.frequency_hz
    band = (float(0.93 * hz[1]), float(1.07 * hz[1]))
    found = changes_for_free_band(known, band, by, [1, 2, 3, 4])
    sizes = [a.size for a in found if a.feasible]
    assert sizes
    assert sizes == sorted(sizes)
    for answer in found:
        for size, free in ((1.0001 * answer.size, True), (0.9999 * answer.size, False)):
            if answer.feasible:
                changed = known.with_changes([Element(answer.at, **{by: size})]).modes.frequency_hz
                assert free == (not np.any((changed > band[0]) & (changed < band[1])))


def test_a_band_that_a_mode_cannot_leave_names_the_mode() -> None:
    known = KnownStructure(BARE.model())
    hz = known.modes.frequency_hz
    none = [a for a in changes_for_free_band(known, (1e-3 * hz[0], 1.01 * hz[0]), "mass", [3]) if not a.feasible]
    assert [a.stays for a in none] == [1]
    free = changes_for_free_band(known, (float(1.05 * hz[0]), float(1.06 * hz[0])), "mass", [1])[0]
    assert free.size == 0 or free.feasible


def test_damping_that_cannot_be_negative_is_the_part_above_zero() -> None:
    rng = np.random.default_rng(0)
    zeta, sigma = np.array([-0.002, 0.001, 0.01]), np.array([0.004, 0.003, 1e-4])
    mean, deviation = passive_damping(zeta, sigma)
    for z, s, m, d in zip(zeta, sigma, mean, deviation, strict=True):
        drawn = z + np.hypot(s, min(z, 0)) * rng.standard_normal(400_000)
        kept = drawn[drawn >= 0]
        assert m == pytest.approx(kept.mean(), rel=0.01)
        assert d == pytest.approx(kept.std(), rel=0.01)


def test_damping_far_below_zero_is_not_stated_as_well_known() -> None:
    mean, deviation = passive_damping(np.array([-0.006]), np.array([1e-4]))
    assert mean[0] + 1.96 * deviation[0] > 0.006
