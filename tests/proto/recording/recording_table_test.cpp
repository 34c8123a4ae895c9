// Tables of recordings. Truth: the numbers that were recorded.
#include "proto/recording/recording_table.h"

#include <doctest/doctest.h>

#include <fstream>
#include <string>

#include "server/recorder/recorder.h"
#include "tests/server/recorder/sample_ticks.h"
#include "tests/support/german_locale.h"
#include "tests/support/skip.h"

namespace hapticd::test {
namespace {

/// A recording of one tone, at 440.5 Hz.
void write_tone(const std::string& path) {
  Recorder recorder;
  recorder.begin(sample_header());
  recorder.add(RecordKind::kScene, 0, sample_scene(1));
  REQUIRE(recorder.start(path));
  v1::EventRecord event;
  event.set_tick(7);
  event.mutable_item()->mutable_tone()->set_t_ns(7'000'000);
  event.mutable_item()->mutable_tone()->set_frequency_hz(440.5F);
  recorder.add(RecordKind::kEvent, 7'000'000, event);
  recorder.stop();
}

}  // namespace

TEST_CASE("a table has decimal points where the locale has commas") {
  const GermanLocale german;
  if (!german.in_force()) return skip("no German locale can be made: " + german.said());
  const TemporaryFolder folder;
  write_tone(folder.file("a.mcap"));
  REQUIRE(write_table(folder.file("a.mcap"), TableRows::kEvents, TableForm::kCsv,
                      folder.file("a.csv")) == 1);
  std::ifstream file(folder.file("a.csv"));
  std::string names;
  std::string row;
  REQUIRE(std::getline(file, names));
  REQUIRE(std::getline(file, row));
  CHECK(names.starts_with("tick,kind,t_ns,tool_id,string_index,phase,cause,latched,frequency_hz,"));
  CHECK(row.starts_with("7,1,7000000,0,0,0,0,0,440.5,0,"));
}

}  // namespace hapticd::test
