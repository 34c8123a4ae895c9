// The rules about requests against the table of PROTOCOL.md, section 8.
#include "server/network/request_rules.h"

#include <doctest/doctest.h>

#include <map>
#include <string>

#include "tests/protocol/request_table.h"

namespace hapticd::test {
namespace {

TEST_CASE("exactly the Items of the document's table are requests, and need what it says") {
  const std::map<std::string, std::string> needs = documented_requests();
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
