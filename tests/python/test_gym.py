"""The Gymnasium environment: its own checker is content, the same seed is the same episode, rewards are what is written."""

from __future__ import annotations

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import rollerrig as rr
from rollerrig.config import Case, ConfigError
from rollerrig.interfaces.gym import BenchEnv, make_vector


def noisy() -> Case:
    load = {"bandwidth": "50 Hz", "noise": 300.0, "resolution": 100.0}
    return rr.load_case("adhesion_brake").with_changes({"time.duration": "0.5 s", "sensors.axle_load": load})


@pytest.mark.parametrize(
    ("case", "controller"),
    [
        ("adhesion_brake", "slide_protection"),
        ("adhesion_brake", "rig_control"),
        ("adhesion_start", "wheel_slip_control"),
    ],
)
def test_gymnasiums_checker_has_nothing_to_say(case: str, controller: str) -> None:
    if "rollerrig/Bench-v0" not in gymnasium.registry:
        gymnasium.register("rollerrig/Bench-v0", entry_point=BenchEnv)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("rollerrig/Bench-v0", case=case, controller=controller).unwrapped)


def episode(env: BenchEnv, seed: int) -> tuple[np.ndarray, list[float]]:
    first, _ = env.reset(seed=seed)
    env.action_space.seed(1)
    rows, rewards, ended = [first], [], False
    while not ended:
        observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        rows.append(observation)
        rewards.append(reward)
        ended = terminated or truncated
    return np.array(rows), rewards


def test_the_same_seed_is_the_same_episode_and_another_one_is_not() -> None:
    env = BenchEnv(noisy())
    (one, rewards), (other, _), (again, repeated) = (episode(env, seed) for seed in (1, 2, 1))
    np.testing.assert_array_equal(one, again)
    assert rewards == repeated
    assert not np.array_equal(one, other)
    assert len(rewards) == round(0.5 / env.period)


def test_reward_of_slide_protection_is_the_speed_lost_less_slip() -> None:
    """While no axle slips more than 10 %, the rewards of an episode sum to the speed that the train has lost."""
    env = BenchEnv(rr.load_case("adhesion_brake").with_changes({"time.duration": "0.7 s"}), "slide_protection")
    _, begin = env.reset(seed=0)
    total, ended = 0.0, False
    while not ended:
        _, reward, terminated, ended, info = env.step([0, 0])
        assert not terminated
        total += reward
    assert begin["train_speed"] - info["train_speed"] > 1e-3
    assert total == pytest.approx(begin["train_speed"] - info["train_speed"], rel=1e-9)


def test_an_unknown_controller_is_refused_with_a_guess() -> None:
    with pytest.raises(ConfigError, match=r"controller: 'slide_protecton'; allowed: .*did you mean 'slide_protection'"):
        BenchEnv("adhesion_brake", "slide_protecton")


@pytest.mark.slow
def test_side_by_side_they_are_the_same_episodes() -> None:
    vector = make_vector(noisy(), count=2)
    try:
        observations, _ = vector.reset(seed=[1, 2])
        for seed, row in zip((1, 2), observations, strict=True):
            np.testing.assert_array_equal(row, BenchEnv(noisy()).reset(seed=seed)[0])
        _, rewards, *_ = vector.step(np.zeros((2, 2), dtype=int))
        assert np.all(np.isfinite(rewards))
    finally:
        vector.close()
