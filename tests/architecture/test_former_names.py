"""Public names of the last release give the new ones, with a warning that says what to write."""

import pytest

import hjsolve


@pytest.mark.parametrize(
    ("former", "new"),
    [("Coordinates", "SeparableCoordinates"), ("Swept", "SweepResult"), ("linear_modes", "gyroscopic_modes")],
)
def test_a_former_name_of_the_package_is_the_new_one(former, new):
    with pytest.warns(DeprecationWarning, match=f"hjsolve.{former} is called hjsolve.{new} now"):
        assert getattr(hjsolve, former) is getattr(hjsolve, new)
    assert former not in dir(hjsolve)
    assert new in dir(hjsolve)


def test_former_names_of_motions_and_batches():
    motion = hjsolve.solve("kepler-planar").motion(q={"r": 1.0, "theta": 0}, p={"r": 0.1, "theta": 1.1})
    with pytest.warns(DeprecationWarning, match="Motion.input_sensitivity"):
        assert motion.input_doubt() == motion.input_sensitivity()
    batch = hjsolve.ensemble("kepler-planar", {"r": [1.0], "theta": 0}, {"r": 0.1, "theta": 1.1}, want="actions")
    with pytest.warns(DeprecationWarning, match="Batch.recomputed"):
        assert batch.exact.tolist() == batch.recomputed.tolist() == [False]
