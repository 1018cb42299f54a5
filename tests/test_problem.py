"""The waist: a Problem that contradicts itself is refused where it is made."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.distributions import NORMAL, UNIFORM
from budget.errors import ProblemError
from budget.methods.gum import propagate
from budget.methods.trials import first_trials
from budget.problem import LEAST_U, MOST_U, Group, Output, Problem


def group(covariance, *, shapes=None, mean=None, name="x"):
    """Return a group of that covariance."""
    C = np.array(covariance, dtype=float)
    return Group(
        name=name,
        mean=np.zeros(len(C)) if mean is None else np.array(mean, dtype=float),
        covariance=C,
        distributions=shapes or (NORMAL,) * len(C),
    )


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: group([[1.0]], mean=[0.0, 0.0]), "shape"),
        (lambda: group([[1.0]], shapes=(NORMAL, NORMAL)), "distributions"),
        (lambda: group([[np.nan]]), "finite"),
        (lambda: group([[1.0, 0.5], [0.4, 1.0]]), "symmetric"),
        (lambda: group([[-1.0]]), "negative"),
        (lambda: group([[1.0, 2.0], [2.0, 1.0]]), "larger than 1"),
    ],
)
def test_a_group_that_is_none_is_refused(make, words):
    """Each contradiction raises ProblemError and says what is wrong."""
    with pytest.raises(ProblemError, match=words):
        make()


def test_an_indefinite_covariance_is_refused_where_it_is_given():
    """Pairwise correlations of -0.9 among three inputs have the eigenvalue -0.8."""
    with pytest.raises(ProblemError, match=r"eigenvalue -0\.8.*times 0\.556"):
        group(np.full((3, 3), -0.9) + 1.9 * np.eye(3))


def test_the_remedy_for_an_indefinite_covariance_is_one():
    """The same correlations times 0.555 are taken, and 0.56 times are not."""
    group(np.full((3, 3), -0.9 * 0.555) + (1.0 + 0.9 * 0.555) * np.eye(3))
    with pytest.raises(ProblemError, match="eigenvalue"):
        group(np.full((3, 3), -0.9 * 0.56) + (1.0 + 0.9 * 0.56) * np.eye(3))


def test_lists_are_taken_as_arrays_and_tuples():
    """A Problem of lists is that of arrays; one distribution may stand alone."""
    found = Group(
        name="x",
        mean=[1, 2],
        covariance=[[4, 0], [0, 9]],
        distributions=[NORMAL, UNIFORM],
    )
    assert found.distributions == (NORMAL, UNIFORM)
    assert_allclose(found.factor, [[2.0, 0.0], [0.0, 3.0]], rtol=0)
    alone = Group(name="x", mean=[1.0], covariance=[[4.0]], distributions=UNIFORM)
    assert alone.distributions == (UNIFORM,)
    several = Group.independent("z", u=[1, 2], mean=[3], distribution=[NORMAL, UNIFORM])
    assert_allclose(several.mean, [3.0, 3.0], rtol=0)
    problem = Problem(groups=[found], outputs=[Output(name="y")], function=np.copy)
    assert (problem.groups, problem.n_inputs) == ((found,), 2)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"mean": ["a"]}, "mean is no array"),
        ({"mean": [1.0 + 1.0j]}, "mean is no array"),
        ({"covariance": [[1.0], [1.0, 2.0]]}, "covariance is no array"),
        ({"mean": 1.0}, "shape"),
        ({"distributions": ["uniform"]}, "distributions has 'uniform'"),
        ({"distributions": None}, "distributions has None"),
        ({"name": 7}, "a name is a text"),
    ],
)
def test_arguments_of_no_meaning_are_refused_in_words(arguments, words):
    """What is no array, no distribution or no text raises ProblemError."""
    good = {
        "name": "x",
        "mean": [0.0],
        "covariance": [[1.0]],
        "distributions": (NORMAL,),
    }
    with pytest.raises(ProblemError, match=words):
        Group(**(good | arguments))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"u": "one"}, "u is no array"),
        ({"u": [1.0, 2.0], "mean": [1.0, 2.0, 3.0]}, "one mean for each"),
        ({"u": [[1.0, 2.0]]}, "one u for each"),
        ({"u": np.nan}, "finite"),
        ({"u": [1.0, 1e-200]}, "is 1e-200, whose powers"),
        ({"u": 1e200}, r"is 1e\+200, whose powers"),
        ({"u": [1.0, 2.0], "distribution": (UNIFORM,)}, "1 distributions"),
        ({"u": 1.0, "distribution": "uniform"}, "distributions has 'uniform'"),
    ],
)
def test_independent_inputs_of_no_meaning_are_refused_in_words(arguments, words):
    """Group.independent raises ProblemError for them too."""
    with pytest.raises(ProblemError, match=words):
        Group.independent("x", **arguments)


@pytest.mark.parametrize("u", [LEAST_U, MOST_U])
def test_what_has_a_size_varies(u):
    """The smallest and the largest u that are taken come out of the law again."""
    own = Group.independent("x", u=u)
    problem = Problem(groups=(own,), outputs=(Output(name="y"),), function=np.copy)

    assert not own.is_constant
    assert_allclose(propagate(problem).standard_uncertainty, [u], rtol=1e-14)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"groups": ["x"]}, "class Group"),
        ({"outputs": ["y"]}, "class Output"),
        ({"function": 3.0}, "callable"),
    ],
)
def test_a_problem_of_other_things_is_refused_in_words(change, words):
    """Groups, outputs and the function must be such."""
    good = {
        "groups": [Group.independent("x", u=1.0)],
        "outputs": [Output(name="y")],
        "function": np.copy,
    }
    with pytest.raises(ProblemError, match=words):
        Problem(**(good | change))


def test_a_function_that_returns_no_array_is_refused_in_words():
    """Rows of different length raise ProblemError."""
    problem = Problem(
        groups=(Group.independent("x", u=[1.0, 1.0]),),
        outputs=(Output(name="y"),),
        function=lambda x: [x[0], x[1][:2]],
    )
    with pytest.raises(ProblemError, match="no array"):
        problem.evaluate(np.zeros((2, 5)))


@pytest.mark.parametrize(
    "covariance",
    [
        [[4.0, 0.0], [0.0, 9.0]],
        [[4.0, 3.0], [3.0, 9.0]],
        [[1.0, 1.0], [1.0, 1.0]],  # singular
        [[0.0, 0.0, 0.0], [0.0, 2.0, 1.0], [0.0, 1.0, 2.0]],  # one constant
        [[1.0, 0.9e-9], [0.9e-9, 1e-18]],  # very different sizes
    ],
)
def test_factor_reproduces_the_covariance(covariance):
    """F F^T is the covariance, relative to the sizes of its two inputs."""
    found = group(covariance)
    scale = np.sqrt(np.diag(found.covariance))
    scale = np.where(scale > 0.0, scale, 1.0)
    error = (found.factor @ found.factor.T - found.covariance) / np.outer(scale, scale)
    assert_allclose(error, np.zeros_like(error), rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("groups", "outputs", "words"),
    [
        (("a",), (), "output"),
        (("a", "a"), ("y",), "twice: a"),
        (("a",), ("y", "y"), "twice: y"),
    ],
)
def test_names_must_be_there_and_differ(groups, outputs, words):
    """Missing and repeated names are refused."""
    with pytest.raises(ProblemError, match=words):
        Problem(
            groups=tuple(Group.independent(name, u=1.0) for name in groups),
            outputs=tuple(Output(name=name) for name in outputs),
            function=np.copy,
        )


def test_a_function_of_wrong_shape_is_named():
    """One row too many is refused with both shapes in the message."""
    problem = Problem(
        groups=(Group.independent("x", u=[1.0, 1.0]),),
        outputs=(Output(name="y"),),
        function=np.copy,
    )
    with pytest.raises(ProblemError, match=r"\(2, 5\).*\(1, 5\)"):
        problem.evaluate(np.zeros((2, 5)))


def test_constants_are_not_counted_among_the_draws():
    """A group of zero uncertainty adds inputs but no normals."""
    problem = Problem(
        groups=(Group.independent("x", u=[1.0, 2.0]), Group.independent("c", u=0.0)),
        outputs=tuple(Output(name=n) for n in "abc"),
        function=np.copy,
    )
    assert (problem.n_inputs, problem.normals_per_trial) == (3, 2)


def test_groups_cannot_be_changed_behind_ones_back():
    """Means and covariances are read-only."""
    with pytest.raises(ValueError, match="read-only"):
        group([[1.0]]).mean[0] = 3.0


def pool_of_two(second):
    """Return x1 + x2 squared, both of one pool, x3 on its own; `second` is x2's."""
    return Problem(
        groups=(
            Group(
                name="x1",
                mean=[1.0],
                covariance=[[4.0]],
                distributions=[NORMAL],
                pool="sum",
            ),
            Group.independent("x3", u=[0.5]),
            Group(
                name="x2",
                mean=[2.0],
                covariance=[[9.0]],
                distributions=[second],
                pool="sum",
            ),
        ),
        outputs=(Output(name="y"),),
        function=lambda z: z[:1] ** 2 + z[1:],
    )


def test_groups_of_a_pool_reach_the_function_as_their_sum():
    """Y = (x1 + x2)^2 + x3: value, law and the law of the pooled Problem agree."""
    problem = pool_of_two(NORMAL)
    x = np.array([[3.0], [0.25], [4.0]])
    assert_allclose(problem.evaluate(x), [[49.25]], rtol=1e-14)
    pooled = problem.pooled
    assert [group.name for group in pooled.groups] == ["sum", "x3"]
    assert_allclose(pooled.groups[0].covariance, [[13.0]], rtol=1e-14)
    apart, together = propagate(problem), propagate(pooled)
    # E = 3^2 + 13, Var = 4 3^2 13 + 2 13^2 + 0.25.
    for law in (apart, together):
        assert_allclose(law.mean, [22.0], rtol=1e-13)
        assert_allclose(law.covariance, [[806.25]], rtol=1e-13)


def test_a_pool_keeps_members_that_are_not_normal():
    """Only normal vectors add up to a normal one: a uniform member stays apart."""
    problem = pool_of_two(UNIFORM)
    pooled = problem.pooled
    assert sorted(group.name for group in pooled.groups) == ["x1", "x2", "x3"]
    x = {"x1": 3.0, "x2": 4.0, "x3": 0.25}
    at = np.array([[x[group.name]] for group in pooled.groups])
    assert_allclose(pooled.evaluate(at), [[49.25]], rtol=1e-14)


def test_a_pool_of_two_sizes_is_refused():
    """Members of one pool have one size, or nobody knows what to add to what."""
    groups = tuple(
        Group(
            name=f"x{n}",
            mean=np.zeros(n),
            covariance=np.eye(n),
            distributions=(NORMAL,) * n,
            pool="sum",
        )
        for n in (1, 2)
    )
    problem = Problem(groups=groups, outputs=(Output(name="y"),), function=np.sin)
    with pytest.raises(ProblemError, match="'sum'"):
        problem.evaluate(np.zeros((3, 1)))


def scaled(y):
    """Return three times the first output, and the product of both."""
    return np.stack([3.0 * y[0], y[0] * y[1]])


def summed(x):
    """Return sum and difference of the first two inputs."""
    return np.stack([x[0] + x[1], x[0] - x[1]])


def chain():
    """Return a Problem of two inputs of u 1 and 2, mean 5 and 0, with a map behind."""
    inputs = Group.independent("x", u=[1.0, 2.0], mean=[5.0, 0.0])
    first = Problem(
        groups=(inputs,),
        outputs=(Output(name="sum"), Output(name="difference")),
        function=summed,
    )
    return first.then(scaled, [Output(name="scaled"), Output(name="product")])


def test_what_follows_is_solved_as_one_model():
    """u(3 (a + b)) is 3 sqrt 5; a^2 - b^2 has mean 22, variance 100 + 2 + 32 = 134.

    Their covariance is 3 cov(a, a^2) = 30, as b has mean 0.
    """
    law = propagate(chain())

    assert_allclose(law.mean, [15.0, 25.0 + 1.0 - 4.0], rtol=1e-12)
    assert_allclose(law.covariance, [[45.0, 30.0], [30.0, 134.0]], rtol=1e-12)


def test_trials_of_what_follows_are_those_of_the_first_outputs():
    """The same inputs are drawn, in any process: the map of their values, exactly."""
    whole = chain()
    first = replace(whole, outputs=whole.outputs, function=summed)
    y = first_trials(first, trials=5000, seed=4)
    found = first_trials(whole, trials=5000, seed=4)

    assert np.array_equal(found, scaled(y))
    assert not np.array_equal(found, first_trials(whole, trials=5000, seed=5))
    sent = pickle.loads(pickle.dumps(whole))  # noqa: S301 - of this process
    assert np.array_equal(first_trials(sent, trials=5000, seed=4), found)


def test_a_map_of_the_wrong_shape_is_refused():
    """One row too few behind, or in front of it: the shapes are said."""
    whole = chain()
    with pytest.raises(ProblemError, match=r"shape \(2, 1\).*expected \(1, 1\)"):
        propagate(whole.then(scaled, [Output(name="alone")]))
    with pytest.raises(ProblemError, match="named twice: a"):
        whole.then(scaled, [Output(name="a"), Output(name="a")])
