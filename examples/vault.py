"""A gymnast on the vaulting table: the best activations that few searches find."""

import plantigrade as pg

run = pg.vault(starts=1, optimiser="evolution", evaluations=1500)
print(
    f"off the table at {run.figures['take_off_speed_m_s']:.2f} m/s upward "
    f"after {run.figures['contact_time_s']:.2f} s"
)
activation = run.record.signals["vault.activation"]
for joint, values in zip(run.record.signals["vault.joints"][2:3], activation.T[2:3], strict=True):
    print(f"activation of the {joint} from {values.min():.1f} to {values.max():.1f}")
print("report:", run.report())
