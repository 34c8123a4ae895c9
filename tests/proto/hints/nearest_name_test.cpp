// Names that people mistype. Truth: what was done to a name to spoil it.
#include "proto/hints/nearest_name.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::hints::test {
namespace {

using hapticd::test::scaled;
using hapticd::test::SplitMix64;

const std::vector<std::string> kNames{
    "guqin", "guqin_coarse", "sphere", "strings[*].tension_n", "strings[*].radius_m", "wall"};

}  // namespace

TEST_CASE("a name with a letter wrong, missing, too many or exchanged is found") {
  for (const char* typed : {"guqim", "guqn", "guqqin", "gquin", "GUQIN"}) {
    CAPTURE(typed);
    CHECK(nearest_name(typed, kNames) == "guqin");
  }
  CHECK(nearest_name("strings[*].tension", kNames) == "strings[*].tension_n");
  CHECK(did_you_mean("spere", kNames) == " Did you mean sphere?");
}

TEST_CASE("a beginning of three letters is enough, of two it is not") {
  CHECK(nearest_name("sph", kNames) == "sphere");
  CHECK(nearest_name("st", kNames).empty());
}

TEST_CASE("what is like nothing, empty or very long is told nothing") {
  CHECK(nearest_name("violin", kNames).empty());
  CHECK(nearest_name("", kNames).empty());
  CHECK(nearest_name(std::string(65, 'g'), kNames).empty());
  CHECK(did_you_mean("violin", kNames).empty());
  CHECK(nearest_name("guqin", {}).empty());
}

TEST_CASE("whatever two edits do to a name of nine letters or more, it is found among others") {
  SplitMix64 random(31);
  const std::vector<std::string> names{"demonstration", "bunny_two_lines", "extreme_presses"};
  for (std::int64_t trial = 0; trial < scaled(20000); ++trial) {
    const std::string& meant = names[random.next() % names.size()];
    std::string typed = meant;
    for (int edit = 0; edit < 2; ++edit) {
      const std::size_t at = random.next() % typed.size();
      const char letter = static_cast<char>('a' + random.next() % 26);
      switch (random.next() % 3) {
        case 0:
          typed[at] = letter;
          break;
        case 1:
          typed.erase(at, 1);
          break;
        default:
          typed.insert(at, 1, letter);
          break;
      }
    }
    CAPTURE(typed);
    REQUIRE(nearest_name(typed, names) == meant);
  }
}

}  // namespace hapticd::hints::test
