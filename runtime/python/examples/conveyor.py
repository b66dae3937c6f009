"""A belt carries parcels past a light barrier, which is a sensor."""

import atoll

world = atoll.World()
world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace(offset=-2))
world.add_body(
    type=atoll.BodyType.STATIC,
    shape=atoll.Box([4, 0.5, 0.1]),
    position=[0, 0, -0.1],
    surface_velocity=[1.5, 0, 0],
    material=atoll.Material(friction=0.8),
)
barrier = world.add_body(
    type=atoll.BodyType.STATIC, shape=atoll.Box([0.01, 0.5, 0.3]), position=[3, 0, 0.3], sensor=True
)

for step in range(600):
    if step % 60 == 0 and step < 300:
        world.add_body(shape=atoll.Box([0.2, 0.15, 0.1]), position=[-3.5, 0, 0.15], name=f"parcel {step // 60}")
    world.step(1 / 60)
    for event in world.sensor_events():
        if event["entered"]:
            body = atoll.BodyId(*event["body"].item())
            print(f"{(step + 1) / 60:5.2f} s: {world.name(body)} at {world.velocity(body)[0]:.2f} m/s")
