"""How wrong is it? The audit of a built-in scene, by code that shares nothing with the simulation."""

import atoll

for substeps in (2, 4, 8):
    scene = atoll.load_scene("pyramid3d:layers=6")
    settings = scene.settings
    settings.substeps = substeps
    scene.settings = settings
    world = scene.build()
    meter = atoll.ErrorMeter(scene)
    ms = 0.0
    for step in range(120):
        ms += world.step(scene.dt).ms
        meter.observe((step + 1) * scene.dt, world)
    errors = meter.errors()
    print(
        f"{substeps} substeps: {ms / 120:.3f} ms a step, bodies overlap by {1e6 * errors['penetration_max']:.0f} um, "
        f"sink by {1e6 * errors['sink_max']:.0f} um"
    )
