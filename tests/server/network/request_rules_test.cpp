// The rules about requests against the table of PROTOCOL.md, section 8.
#include "server/network/request_rules.h"

#include <doctest/doctest.h>

#include <fstream>
#include <map>
#include <regex>
#include <string>

namespace hapticd::test {
namespace {

/// What each request of the table needs: "", "control" or "lease".
std::map<std::string, std::string> needs_of_document() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/proto/PROTOCOL.md");
  REQUIRE(file.good());
  std::map<std::string, std::string> needs;
  const std::regex row("\\| (`\\w+`(?:, `\\w+`)*) \\| (control|lease|) ?\\|.*");
  const std::regex name("\\w+");
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("## ", 0) == 0) inside = line == "## 8 Requests";
    std::smatch match;
    if (!inside || !std::regex_match(line, match, row)) continue;
    const std::string names = match[1];
    for (std::sregex_iterator each(names.begin(), names.end(), name);
         each != std::sregex_iterator(); ++each) {
      needs[each->str()] = match[2];
    }
  }
  return needs;
}

TEST_CASE("exactly the Items of the document's table are requests, and need what it says") {
  const std::map<std::string, std::string> needs = needs_of_document();
  CHECK(needs.size() >= 24);
  const auto* body = v1::Item::descriptor()->FindOneofByName("body");
  for (int i = 0; i < body->field_count(); ++i) {
    const auto* field = body->field(i);
    CAPTURE(field->name());
    v1::Item item;
    v1::Item::GetReflection()->MutableMessage(&item, field);
    // Bye is in the table, but has no Result and is dealt with apart.
    const bool listed = needs.count(field->name()) > 0 && field->name() != "bye";
    CHECK(is_request(item) == listed);
    CHECK(needs_lease(item) == (listed && needs.at(field->name()) == "lease"));
  }
  CHECK(!is_request(v1::Item()));
}

}  // namespace
}  // namespace hapticd::test
