// Names are text: in UTF-8, or refused.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <string>

#include "support/bodies.h"
#include "support/expect_error.h"
#include "world/utf8.h"

namespace atl::test {
namespace {

// Examples of RFC 3629, sections 3 and 10, and of the Unicode standard's table 3-7.
TEST(Utf8, IsWhatTheStandardSays) {
  for (const char* text : {"", "crate", "caf\xc3\xa9", "\xe2\x89\xa2\xce\x91.", "\xed\x9f\xbf", "\xee\x80\x80",
                           "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_TRUE(is_utf8(text)) << text;
  }
  for (const char* text : {"\x80", "\xc3", "\xc3(", "\xc0\x80", "\xc1\xbf", "\xe0\x9f\xbf", "\xe2\x89", "\xed\xa0\x80",
                           "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff", "ab\xe2\x89g"}) {
    EXPECT_FALSE(is_utf8(text)) << text;
  }
}

TEST(Names, ThatAreNotTextAreRefused) {
  World world;
  BodyDef def = box({0, 0, 1});
  def.name = "caf\xe9";
  expect_error([&] { world.add_body(def); }, {"BodyDef.name has 4 bytes that are not UTF-8; expected text that is"});
  for (const char* name : {"a\nb", "\x1b[2J", "\x7f", "\xc2\x9b"}) {
    def.name = name;
    expect_error([&] { world.add_body(def); }, {"BodyDef.name has control characters; expected text without them"});
  }
  def.name = "caf\xc3\xa9";
  const BodyId id = world.add_body(def);
  expect_error([&] { world.set_name(id, "\xff"); },
               {"World::set_name: name has 1 bytes that are not UTF-8; expected text that is"});
  EXPECT_EQ(world.name(id), "caf\xc3\xa9");
  const BodyId other = world.add_body(box({0, 0, 3}));
  expect_error([&] { world.add_joint({.first = id, .second = other, .name = "\xc3"}); },
               {"JointDef.name has 1 bytes that are not UTF-8; expected text that is"});
  EXPECT_EQ(parse_scene(scene_text(scene_of(world)), "written").bodies[0].name, "caf\xc3\xa9");
}

}  // namespace
}  // namespace atl::test
