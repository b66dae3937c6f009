#pragma once

#include "json_document.h"
#include "memory_need.h"

namespace atl::scene {

/// Estimates the size of a scene file before anything of it is made: its bodies, those of its generators, joints, and
/// the points of hulls and triangles that are written out in it. Invalid parts count for nothing here; reading reports
/// them.
SceneSize size_of_file(const JsonValue& root);

}  // namespace atl::scene
