// Sizes and alignments that kernels rely on: they load rows of four floats with aligned 16-byte loads, and a
// row must not straddle a cache line.

#include <collision/contacts/contact.h>
#include <gtest/gtest.h>
#include <solver/integrate/solver_bodies.h>
#include <solver/sweep/contact_block.h>

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace atl::solver {
namespace {

template <typename Row>
void expect_row(std::size_t size) {
  EXPECT_EQ(sizeof(Row), size);
  EXPECT_EQ(alignof(Row), size);
  EXPECT_TRUE(std::is_trivially_copyable_v<Row>);
  EXPECT_TRUE(std::is_standard_layout_v<Row>);
}

TEST(Layout, BodyRowsFillTheirAlignment) {
  expect_row<VelocityRows>(32);
  expect_row<InertiaRow>(16);
  expect_row<DisplacementRows>(32);
  expect_row<FreeVelocityRows>(32);
  expect_row<AccelerationRows>(32);
}

TEST(Layout, SecondRowsStartAtSixteenBytes) {
  EXPECT_EQ(offsetof(VelocityRows, angular), 16u);
  EXPECT_EQ(offsetof(DisplacementRows, rotation), 16u);
  EXPECT_EQ(offsetof(FreeVelocityRows, angular), 16u);
  EXPECT_EQ(offsetof(AccelerationRows, angular), 16u);
  EXPECT_EQ(sizeof(GyroscopicRows), 48u);
  EXPECT_EQ(alignof(GyroscopicRows), 16u);
  EXPECT_EQ(offsetof(GyroscopicRows, ratio), 16u);
  EXPECT_EQ(offsetof(GyroscopicRows, moment), 32u);
}

TEST(Layout, ManifoldIsTwoCacheLinesOfRows) {
  using collision::ContactManifold;
  EXPECT_EQ(sizeof(ContactManifold), 128u);
  EXPECT_EQ(alignof(ContactManifold), 64u);
  EXPECT_TRUE(std::is_trivially_copyable_v<ContactManifold>);
  EXPECT_EQ(offsetof(ContactManifold, normal), 0u);
  EXPECT_EQ(offsetof(ContactManifold, anchor_first), 16u);
  EXPECT_EQ(offsetof(ContactManifold, anchor_second), 32u);
  EXPECT_EQ(offsetof(ContactManifold, x), 48u);
  EXPECT_EQ(offsetof(ContactManifold, y), 64u);
  EXPECT_EQ(offsetof(ContactManifold, separation), 80u);
  EXPECT_EQ(offsetof(ContactManifold, normal_impulse), 96u);
  EXPECT_EQ(offsetof(ContactManifold, friction_impulse), 112u);
}

TEST(Layout, BlockLanesAreAlignedForTheWidestSet) {
  EXPECT_EQ(alignof(ContactBlock), 64u);
  EXPECT_EQ(alignof(BounceBlock), 64u);
  EXPECT_EQ(sizeof(ContactBlock) % 64, 0u);
  constexpr std::size_t row = block_lanes * sizeof(float);
  EXPECT_EQ(row, 32u);
  EXPECT_EQ(offsetof(ContactBlock, normal) % row, 0u);
  EXPECT_EQ(offsetof(ContactBlock, torsional_impulse) % row, 0u);
  EXPECT_EQ(offsetof(ContactBlock, friction_radius) % row, 0u);
  EXPECT_EQ(offsetof(BounceBlock, restitution) % row, 0u);
}

// An aligned vector element, for the loads above, in every row of every vector.
TEST(Layout, BodiesArePaddedToBlocks) {
  SolverBodies bodies;
  bodies.reset(9, {.gyroscopic = true});
  EXPECT_EQ(bodies.padded_count(), 16u);
  EXPECT_EQ(bodies.gyroscopic.size(), 16u);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(bodies.velocity.data()) % 32, 0u);
  EXPECT_EQ(bodies.displacement[12].rotation[3], 1.0f);
  EXPECT_EQ(bodies.acceleration[0].linear_damping, 1.0f);
  bodies.reset(8, {});
  EXPECT_EQ(bodies.padded_count(), 8u);
  EXPECT_TRUE(bodies.gyroscopic.empty());
}

}  // namespace
}  // namespace atl::solver
