// The table of requests in proto/PROTOCOL.md against Item of stream.proto: the same requests, and
// the same of them need the lease.
#include <doctest/doctest.h>

#include <set>
#include <string>

#include "hapticd/v1/stream.pb.h"
#include "tests/protocol/field_comment.h"
#include "tests/protocol/request_table.h"

namespace hapticd::test {
namespace {

struct Requests {
  std::set<std::string> all;
  std::set<std::string> need_lease;
};

Requests requests_of_document() {
  Requests requests;
  for (const auto& [name, need] : documented_requests()) {
    requests.all.insert(name);
    if (need == "lease") requests.need_lease.insert(name);
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
