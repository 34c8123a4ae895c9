// The ladder of quality goes up in effort and down in error.
#include "core/scene/quality.h"

#include <doctest/doctest.h>

namespace hapticd::test {

TEST_CASE("each level works at least as hard as the one below, for less error") {
  for (int level = 1; level < kQualityLevels; ++level) {
    CAPTURE(level);
    const Quality below = quality_of(level - 1);
    const Quality here = quality_of(level);
    CHECK(here.options.sub_steps >= below.options.sub_steps);
    CHECK(here.options.stop_tolerance <= below.options.stop_tolerance);
    CHECK(here.force_error < below.force_error);
    CHECK(here.work > below.work);
  }
  CHECK(quality_of(kDefaultQuality).work == 1.0);
}

TEST_CASE("an error that no level promises is known to be none") {
  const double least = quality_of(kQualityLevels - 1).force_error;
  CHECK(quality_offers(least));
  CHECK_FALSE(quality_offers(0.99 * least));
  CHECK(quality_offers(1.0));
}

TEST_CASE("the default level is the contact problem's own default") {
  const ContactOptions usual;
  const ContactOptions level = quality_of(kDefaultQuality).options;
  CHECK(level.sub_steps == usual.sub_steps);
  CHECK(level.stop_tolerance == usual.stop_tolerance);
  CHECK(level.rotation_step == usual.rotation_step);
}

TEST_CASE("the cheapest level within an error is chosen, the best where none is") {
  for (int level = 0; level < kQualityLevels; ++level) {
    CHECK(quality_for(quality_of(level).force_error) == level);
  }
  CHECK(quality_for(1.0) == 0);
  CHECK(quality_for(1e-12) == kQualityLevels - 1);
}

TEST_CASE(
    "settings taken to a level have what it decides, and keep what the scene decided itself") {
  for (int from = 0; from < kQualityLevels; ++from) {
    for (int to = 0; to < kQualityLevels; ++to) {
      LiveSettings live;
      live.contact = quality_of(from).options;
      live.quality_level = static_cast<std::uint32_t>(from);
      set_level(to, live);
      CHECK(live.contact.sub_steps == quality_of(to).options.sub_steps);
      CHECK(live.contact.stop_tolerance == quality_of(to).options.stop_tolerance);
      CHECK(live.quality_level == static_cast<std::uint32_t>(to));
    }
  }
  LiveSettings own;
  own.quality_level = kDefaultQuality;
  own.contact.sub_steps = 77;
  own.contact.margin = 0.125;
  set_level(0, own);
  CHECK(own.contact.sub_steps == 77);
  CHECK(own.contact.margin == 0.125);
  CHECK(own.contact.stop_tolerance == quality_of(0).options.stop_tolerance);
}

}  // namespace hapticd::test
