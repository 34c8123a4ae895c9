// Profiles of the protocol to sheets and back. Truth: the shipped files as protobuf reads them, and
// the fields of the schema.
#include "server/scene_io/sheet_translation.h"

#include <doctest/doctest.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace hapticd::test {
namespace {

namespace pb = google::protobuf;

v1::DeviceProfile parsed(const std::string& text) {
  v1::DeviceProfile profile;
  REQUIRE(pb::TextFormat::ParseFromString(text, &profile));
  return profile;
}

/// What is lost on the way there and back; empty: nothing.
std::string lost(const v1::DeviceProfile& profile) {
  std::string difference;
  pb::util::MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&difference);
  differencer.Compare(profile, to_profile(to_sheet(profile)));
  return difference;
}

void add_quantities(const pb::Descriptor& type, const std::string& prefix,
                    std::set<std::string>& names) {
  for (int i = 0; i < type.field_count(); ++i) {
    if (type.field(i)->message_type() != v1::Quantity::descriptor()) continue;
    names.insert(prefix + type.field(i)->name());
  }
}

}  // namespace

TEST_CASE("no shipped profile loses anything on the way to a sheet and back") {
  int files = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(HAPTICD_SOURCE_DIR "/deploy/devices")) {
    CAPTURE(file.path().string());
    std::ifstream in(file.path());
    CHECK(lost(parsed({std::istreambuf_iterator<char>(in), {}})) == "");
    ++files;
  }
  CHECK(files >= 7);
}

TEST_CASE("one number for all axes stays one, and axes stated as usual stay stated") {
  CHECK(lost(parsed("name: \"p\" driver: DRIVER_PID affine: true description: \"d\" "
                    "mass_kg { value: 0.2 source: \"s\" guess: true } "
                    "inertia_kg_m2 { value: [1, 2, 3] source: \"t\" } "
                    "axis_map { axes: [AXIS_POSITIVE_X, AXIS_POSITIVE_Y, AXIS_POSITIVE_Z] "
                    "force_sign { value: [1, -1, 1] source: \"check\" } } "
                    "matches { serial: \"\" } matches { usage_page: 0 usage: 4 }")) == "");
}

TEST_CASE("a sheet has a row for each Quantity of the schema, and none beside") {
  std::set<std::string> wanted;
  add_quantities(*v1::DeviceProfile::descriptor(), "", wanted);
  add_quantities(*v1::AxisMap::descriptor(), "axis_map.", wanted);
  std::set<std::string> rows;
  for (const SheetRow& row : kSheetRows) rows.insert(std::string(row.name));
  CHECK(rows == wanted);
  CHECK(rows.size() == kSheetRows.size());
}

}  // namespace hapticd::test
