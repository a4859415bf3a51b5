"""Trains a Panda to reach: its hand comes within 5 cm of a goal that is redrawn in every episode.

The scene is a dict, the environments are `scenecc.gymnasium.SceneVectorEnv`, and the method is PPO. The ManiSkill wheel
contains the robot's URDF; ManiSkill is not imported.

    pip install torch 'scenecc[gymnasium,maniskill]'
    python examples/reach.py
"""

from __future__ import annotations

import argparse
import time
from typing import Any, NamedTuple

import numpy as np
import torch
from gymnasium import spaces
from torch import nn

import scenecc
from scenecc.gymnasium import SceneVectorEnv

HAND = "panda_hand_tcp"
REACHED = 0.05
"""[m] from hand to goal: the episode ends in success."""

STEPS = 50
"""Actions of an episode, at 20 Hz."""

REST = (0, 0.4, 0, -1.96, 0, 2.36, 0.785)
"""[rad] The arm's initial joint positions, before noise of up to 0.1."""

SCENE = {
    "scenecc": 1,
    "physics": {"timestep": 0.01},
    "entities": {
        "panda": {
            "urdf": "pkg://mani_skill/assets/robots/panda/panda_v2.urdf",
            "gravity": False,
            "qpos": [*({"uniform": [q - 0.1, q + 0.1]} for q in REST), 0.02, 0.02],
            "drives": {".*": {"stiffness": 1000, "damping": 100, "force_limit": 100}},
        },
        "goal": {
            "body_type": "kinematic",
            "pose": [{"uniform": [0.3, 0.6]}, {"uniform": [-0.4, 0.4]}, {"uniform": [0.1, 0.6]}],
            "visuals": [{"type": "sphere", "radius": REACHED, "color": [0, 1, 0, 0.5]}],
        },
    },
}


def offset(batch: scenecc.SceneBatch) -> np.ndarray:
    """(N, 3) [m] from the hand to the goal."""
    return batch.entities["goal"].pose[:, :3] - batch.articulations["panda"].link_pose(HAND)[:, 0, :3]


def observe(batch: scenecc.SceneBatch) -> np.ndarray:
    """(N, 13): the arm's joints, the goal, and the offset to it."""
    arm, goal = batch.articulations["panda"].qpos[:, :7], batch.entities["goal"].pose[:, :3]
    return np.hstack([arm, goal, offset(batch)])


def reward(batch: scenecc.SceneBatch) -> np.ndarray:
    """(N,): minus the distance [m], with a bonus at the goal."""
    distance = np.linalg.norm(offset(batch), axis=1)
    return np.where(distance < REACHED, 1.0, -distance)


def reached(batch: scenecc.SceneBatch) -> np.ndarray:
    """(N,) bool: whether the hand is at the goal."""
    return np.linalg.norm(offset(batch), axis=1) < REACHED


def act(batch: scenecc.SceneBatch, actions: np.ndarray) -> None:
    """Sets the arm's drive targets up to 0.15 rad from its joint positions."""
    panda = batch.articulations["panda"]
    target = panda.qpos.copy()
    target[:, :7] += 0.15 * np.clip(actions, -1, 1)
    target[:, 7:] = 0.02
    panda.drive_target = target


def make_envs(count: int) -> SceneVectorEnv:
    """`count` scenes as environments."""
    return SceneVectorEnv(
        scenecc.load_scene(SCENE, num_scenes=count, render=False),
        observation=observe,
        reward=reward,
        terminated=reached,
        act=act,
        action_space=spaces.Box(-1, 1, (7,), np.float32),
        steps_per_action=5,
        max_episode_steps=STEPS,
    )


class Policy(nn.Module):
    """Mean and spread of the actions, and the value of a state."""

    def __init__(self) -> None:
        super().__init__()
        self.mean = nn.Sequential(nn.Linear(13, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, 7))
        self.value = nn.Sequential(nn.Linear(13, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, 1))
        self.log_std = nn.Parameter(torch.full((7,), -0.5))

    def actions(self, observed: torch.Tensor) -> torch.distributions.Normal:
        return torch.distributions.Normal(self.mean(observed), self.log_std.exp())


class Rollout(NamedTuple):
    """Data from T steps of N environments: (T, N, …)."""

    observed: torch.Tensor
    actions: torch.Tensor
    log_probs: torch.Tensor
    advantages: torch.Tensor
    returns: torch.Tensor


def tensor(array: Any) -> torch.Tensor:
    return torch.as_tensor(np.asarray(array), dtype=torch.float32)


@torch.no_grad()
def collect(envs: SceneVectorEnv, policy: Policy, observed: np.ndarray, steps: int) -> tuple[Rollout, np.ndarray]:
    """Acts for some steps, and estimates advantages by GAE (gamma 0.97, lambda 0.95)."""
    rows: list[tuple[torch.Tensor, ...]] = []
    for _ in range(steps):
        state = tensor(observed)
        chosen = policy.actions(state)
        actions = chosen.sample()
        observed, rewards, terminated, truncated, infos = envs.step(actions.numpy())
        following = observed.copy()
        for row in np.flatnonzero(truncated & ~terminated):  # a truncated episode would have continued
            following[row] = infos["final_obs"][row]
        ended, done = tensor(terminated | truncated), tensor(terminated)
        value, ahead = policy.value(state)[:, 0], policy.value(tensor(following))[:, 0]
        delta = tensor(rewards) + 0.97 * (1 - done) * ahead - value
        rows.append((state, actions, chosen.log_prob(actions).sum(1), delta, value, ended))
    states, taken, log_probs, deltas, values, ends = (torch.stack(column) for column in zip(*rows, strict=True))
    advantages, advantage = torch.zeros_like(deltas), torch.zeros(envs.num_envs)
    for step in reversed(range(steps)):
        advantage = deltas[step] + 0.97 * 0.95 * (1 - ends[step]) * advantage
        advantages[step] = advantage
    return Rollout(states, taken, log_probs, advantages, advantages + values), observed


def improve(policy: Policy, optimizer: torch.optim.Optimizer, rollout: Rollout) -> None:
    """PPO's update: 8 epochs over all samples, in minibatches of 512."""
    flat = Rollout(*(each.flatten(0, 1) for each in rollout))
    for _ in range(8):
        for rows in torch.randperm(len(flat.observed)).split(512):
            part = Rollout(*(each[rows] for each in flat))
            chosen = policy.actions(part.observed)
            ratio = (chosen.log_prob(part.actions).sum(1) - part.log_probs).exp()
            advantage = (part.advantages - part.advantages.mean()) / (part.advantages.std() + 1e-8)
            gain = torch.min(ratio * advantage, ratio.clamp(0.8, 1.2) * advantage).mean()
            error = (policy.value(part.observed)[:, 0] - part.returns).square().mean()
            optimizer.zero_grad()
            (0.5 * error - gain).backward()
            nn.utils.clip_grad_norm_(policy.parameters(), 0.5)
            optimizer.step()


@torch.no_grad()
def evaluate(envs: SceneVectorEnv, policy: Policy, seeds: range) -> float:
    """Fraction of episodes that reach their goal: one per environment and seed, without exploration noise."""
    count = 0
    for seed in seeds:
        observed, _ = envs.reset(seed=seed)
        well, running = np.zeros(envs.num_envs, bool), np.ones(envs.num_envs, bool)
        for _ in range(STEPS):
            observed, _, terminated, _, _ = envs.step(policy.mean(tensor(observed)).numpy())
            well |= running & terminated
            running &= ~terminated
        count += int(well.sum())
    return count / (len(seeds) * envs.num_envs)


def train(envs: SceneVectorEnv, iterations: int, seed: int, steps: int = 32) -> Policy:
    """Trains a policy by alternating rollouts and updates."""
    torch.manual_seed(seed)
    policy = Policy()
    optimizer = torch.optim.Adam(policy.parameters(), lr=1e-3)
    observed, _ = envs.reset(seed=seed)
    started = time.monotonic()
    for iteration in range(iterations):
        rollout, observed = collect(envs, policy, observed, steps)
        improve(policy, optimizer, rollout)
        if iteration % 10 == 9 or iteration == iterations - 1:
            print(
                f"{(iteration + 1) * steps * envs.num_envs:7d} steps, {time.monotonic() - started:4.0f} s: "
                f"mean return {rollout.returns.mean():.2f}",
                flush=True,
            )
    return policy


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenes", type=int, default=64)
    parser.add_argument("--iterations", type=int, default=80, help="rounds of 32 steps in every scene")
    parser.add_argument("--episodes", type=int, default=8, help="evaluation episodes in every scene")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    torch.set_num_threads(1)  # the simulation uses the other core
    envs = make_envs(given.scenes)
    held_out = range(2**31, 2**31 + given.episodes)  # training seeds are below
    print(f"untrained: {evaluate(envs, Policy(), held_out):.1%} of episodes reach their goal")
    policy = train(envs, given.iterations, given.seed)
    print(f"trained: {evaluate(envs, policy, held_out):.1%}; {time.process_time():.0f} s of CPU time in total")
    envs.close()


if __name__ == "__main__":
    main()
