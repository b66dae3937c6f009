#pragma once
/// In this program FCL's place is taken by what answers wrongly.

namespace atl::test {

enum class Fcl {
  Silent,  ///< finds no contact
  Turned,  ///< any two shapes touch, along the line of their centres turned by a radian
};

/// For all threads; to be set between steps.
void let_fcl_be(Fcl fault);

}  // namespace atl::test
