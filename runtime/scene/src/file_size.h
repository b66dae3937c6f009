#pragma once

#include "json_document.h"
#include "memory_need.h"

namespace atl::scene {

/// What a scene file asks for, before anything of it is made: its bodies, those of its generators, joints, and the
/// points of hulls and triangles that are written out in it. What is not as it should be counts for nothing here.
SceneSize size_of_file(const JsonValue& root);

}  // namespace atl::scene
