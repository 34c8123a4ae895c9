// What is said to who writes a scene or a configuration wrong. Truth: what was done to a text that
// is right, as protobuf's own parser complains of it.
#include "proto/hints/text_remedy.h"

#include <doctest/doctest.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <cstdint>
#include <string>

#include "hapticd/v1/config.pb.h"
#include "hapticd/v1/scene.pb.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::hints::test {
namespace {

namespace pb = google::protobuf;
using hapticd::test::scaled;
using hapticd::test::SplitMix64;

/// A text may have several faults; the first is told.
class FirstError : public pb::io::ErrorCollector {
 public:
  void AddError(int /*line*/, int /*column*/, const std::string& message) override {
    if (text.empty()) text = message;
  }
  std::string text;
};

/// What is said of `text`, which is no `Message`.
template <typename Message>
std::string said(const std::string& text) {
  Message message;
  FirstError error;
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  CHECK_FALSE(parser.ParseFromString(text, &message));
  CAPTURE(error.text);
  return text_remedy(*Message::descriptor(), error.text);
}

}  // namespace

TEST_CASE("a field or a value that is mistyped is told as it is written") {
  CHECK(said<v1::Config>("lisen: \"x\"") == "Did you mean listen?");
  CHECK(said<v1::Config>("device { sorce: \"hid\" }") == "Did you mean source?");
  CHECK(said<v1::Config>("clock: CLOCK_MODE_VIRTUL") == "Did you mean CLOCK_MODE_VIRTUAL?");
  CHECK(said<v1::Config>("clock: virtual") == "Did you mean CLOCK_MODE_VIRTUAL?");
  CHECK(said<v1::Config>("clock: sundial") == "Choose CLOCK_MODE_REALTIME, CLOCK_MODE_VIRTUAL.");
  CHECK(said<v1::Scene>("strings { nme: \"A\" }") == "Did you mean name?");
  CHECK(said<v1::Scene>("colour: 3").empty());
}

TEST_CASE("what is written in another form than the format's is told the form") {
  CHECK(said<v1::Config>("rate: 1kHz").find("the number alone") != std::string::npos);
  CHECK(said<v1::Config>("rate: \"1kHz\"").find("without quotes") != std::string::npos);
  CHECK(said<v1::Config>("rate: 0,5").find("decimals have a point") != std::string::npos);
  CHECK(said<v1::Config>("listen: x").find("in quotes") != std::string::npos);
  CHECK(said<v1::Config>("clock: \"virtual\"").find("without quotes") != std::string::npos);
  CHECK(said<v1::Config>("rate 5").find("NAME: VALUE") != std::string::npos);
  CHECK(said<v1::Config>("device: \"hid\"").find("NAME { FIELDS }") != std::string::npos);
}

TEST_CASE("every field of a string with one letter too many is told by its name") {
  const pb::Descriptor& type = *v1::String::descriptor();
  const std::uint64_t seed = hapticd::test::fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int i = 0; i < type.field_count(); ++i) {
    std::string name = type.field(i)->name();
    if (name.size() < 4) continue;
    name.insert(random.next() % name.size(), 1, 'q');
    CAPTURE(name);
    CHECK(said<v1::Scene>("strings { " + name + ": 1 }") ==
          "Did you mean " + type.field(i)->name() + "?");
  }
}

TEST_CASE("no message of any kind makes it say what is no sentence") {
  const std::uint64_t seed = hapticd::test::fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  const std::string letters =
      "\":{}[],. abcfieldMessage type has no named Unknown enumeration value of";
  for (int k = 0; k < scaled(20'000); ++k) {
    std::string message;
    for (std::uint64_t n = random.next() % 40; n > 0; --n) {
      const std::size_t at = random.next() % letters.size();
      message += letters.substr(at, random.next() % 12);
    }
    const std::string remedy = text_remedy(*v1::Scene::descriptor(), message);
    CAPTURE(message);
    CHECK((remedy.empty() || remedy.ends_with('.') || remedy.ends_with('?')));
  }
}

}  // namespace hapticd::hints::test
