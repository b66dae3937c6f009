"""A platform that is passed through from below and stood on from above, by a contact modifier."""

import atoll

world = atoll.World()
platform = world.add_body(type=atoll.BodyType.STATIC, shape=atoll.Box([2, 2, 0.05]), position=[0, 0, 2])
ball = world.add_body(shape=atoll.Sphere(0.2), position=[0, 0, 0.5], velocity=[0, 0, 8])


def only_from_above(contact: atoll.ModifiableContact) -> None:
    rises = contact.world.velocity(ball)[2] > 0
    contact.enabled = not rises and contact.world.positions[ball, 2] > 2.05


world.set_contact_modifier(only_from_above)
highest = 0.0
for _ in range(180):
    world.step(1 / 60)
    highest = max(highest, world.positions[ball, 2])
print(f"it rose to {highest:.2f} m, and lies at {world.positions[ball, 2]:.3f} m")
