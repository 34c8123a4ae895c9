// The table of requests in proto/PROTOCOL.md against Item of stream.proto: the same requests, and
// the same of them need the lease.
#include <doctest/doctest.h>

#include <fstream>
#include <regex>
#include <set>
#include <string>

#include "hapticd/v1/stream.pb.h"
#include "tests/protocol/field_comment.h"

namespace hapticd::test {
namespace {

struct Requests {
  std::set<std::string> all;
  std::set<std::string> need_lease;
};

/// Rows such as "| `calibrate`, `recentre` | lease | ... |" of section 8.
Requests requests_of_document() {
  std::ifstream file(HAPTICD_SOURCE_DIR "/proto/PROTOCOL.md");
  REQUIRE(file.good());
  Requests requests;
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
      requests.all.insert(each->str());
      if (match[2] == "lease") requests.need_lease.insert(each->str());
    }
  }
  return requests;
}

Requests requests_of_schema() {
  const CommentedSchema schema;
  Requests requests;
  const auto* body = v1::Item::descriptor()->FindOneofByName("body");
  REQUIRE(body != nullptr);
  for (int i = 0; i < body->field_count(); ++i) {
    const std::string& name = body->field(i)->name();
    const std::string text = schema.of(*body->field(i)).text;
    if (text.rfind("Client to server", 0) == 0 || name == "bye") requests.all.insert(name);
    if (text == "Client to server, needs the lease.") requests.need_lease.insert(name);
  }
  return requests;
}

TEST_CASE("the document and the schema list the same requests") {
  const Requests schema = requests_of_schema();
  CHECK(schema.all.size() >= 24);
  CHECK(requests_of_document().all == schema.all);
}

TEST_CASE("the document and the schema agree on which requests need the lease") {
  const Requests schema = requests_of_schema();
  CHECK(schema.need_lease.size() >= 14);
  CHECK(requests_of_document().need_lease == schema.need_lease);
}

}  // namespace
}  // namespace hapticd::test
