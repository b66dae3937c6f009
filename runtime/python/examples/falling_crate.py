"""A crate falls on the ground, and comes to rest."""

import atoll

world = atoll.World()
world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
crate = world.add_body(shape=atoll.Box([0.5, 0.5, 0.5]), position=[0, 0, 3], density=600)

for step in range(180):
    world.step(1 / 60)
    if step % 30 == 0:
        print(f"{step / 60:.1f} s: {world.positions[crate, 2]:.3f} m")

for contact in world.contact_forces():
    print(f"at {contact['position'].round(2)} it rests with {contact['normal_force']:.0f} N")
