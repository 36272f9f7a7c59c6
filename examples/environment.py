"""The Gymnasium environment: the reference as a policy, which walks a step or two and falls."""

import numpy as np

import plantigrade as pg
import plantigrade.learn

env = plantigrade.learn.WalkEnv(recording=True)
observation, info = env.reset(seed=0, options={"phase": 0.0})
action = np.zeros_like(env.action_space.sample())  # a policy's answer: here always the same
print(f"{observation.size} numbers are seen, {action.size} decided about")
rewards, terminated, truncated = [], False, False
while not (terminated or truncated):
    observation, reward, terminated, truncated, info = env.step(action)
    rewards.append(reward)
print(f"{info['end']} after {len(rewards) / 30:.1f} s, reward {np.mean(rewards):.2f}")
run = pg.Run(env.record(), "simulate", title="Following a walk blindly", name="blind")
print("report:", run.report())
