"""The Gymnasium environment: the reference as a policy, which walks a step or two and falls."""

import gymnasium
import numpy as np

import plantigrade as pg
import plantigrade.learn

env = gymnasium.make(plantigrade.learn.WALK, recording=True)
observation, info = env.reset(seed=0, options={"phase": 0.0})
print(f"{observation.size} numbers are seen, {env.action_space.shape[0]} decided about")
rewards, terminated, truncated = [], False, False
while not (terminated or truncated):
    action = np.zeros(env.action_space.shape, dtype=np.float32)  # a policy's answer
    observation, reward, terminated, truncated, info = env.step(action)
    rewards.append(reward)
print(f"{info['end']} after {len(rewards) / 30:.1f} s, reward {np.mean(rewards):.2f}")
run = pg.Run(env.unwrapped.record(), "simulate", title="Following a walk blindly", name="blind")
print("report:", run.report())
