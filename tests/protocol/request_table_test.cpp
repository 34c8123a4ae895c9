// The table of requests in proto/PROTOCOL.md against the rules and comments of Item in
// stream.proto.
#include <doctest/doctest.h>

#include <map>
#include <string>

#include "proto/wire/request_rule.h"
#include "tests/protocol/field_comment.h"
#include "tests/protocol/request_table.h"

namespace hapticd::test {
namespace {

/// Calls `check` with each field of Item's body and an Item that has it.
template <class Check>
void for_each_kind(Check check) {
  const auto* body = v1::Item::descriptor()->FindOneofByName("body");
  REQUIRE(body != nullptr);
  for (int i = 0; i < body->field_count(); ++i) {
    const auto* field = body->field(i);
    CAPTURE(field->name());
    v1::Item item;
    v1::Item::GetReflection()->MutableMessage(&item, field);
    check(*field, item);
  }
}

TEST_CASE("exactly the Items of the document's table are requests, and need what it says") {
  const std::map<std::string, std::string> needs = documented_requests();
  CHECK(needs.size() >= 24);
  for_each_kind([&](const google::protobuf::FieldDescriptor& field, const v1::Item& item) {
    // Bye is in the table, but has no Result and is dealt with apart.
    const bool listed = needs.count(field.name()) > 0 && field.name() != "bye";
    const std::string need = listed ? needs.at(field.name()) : "";
    CHECK((wire::rule_of(item) != nullptr) == listed);
    CHECK(wire::needs_lease(item) == (need == "lease"));
    CHECK(wire::needs_control(item) == (need == "lease" || need == "control"));
  });
  CHECK(wire::rule_of(v1::Item()) == nullptr);
  CHECK(!wire::needs_lease(v1::Item()));
  CHECK(!wire::needs_control(v1::Item()));
}

TEST_CASE("each rule says what a request needs and costs, and each comment who sends it") {
  const CommentedSchema schema;
  for_each_kind([&](const google::protobuf::FieldDescriptor& field, const v1::Item& item) {
    const v1::RequestRule* rule = wire::rule_of(item);
    CHECK((schema.of(field).text == "Client to server.") == (rule != nullptr));
    if (rule == nullptr) return;
    CHECK(rule->need() != v1::REQUEST_NEED_UNSPECIFIED);
    CHECK(rule->cost() != v1::REQUEST_COST_UNSPECIFIED);
  });
}

TEST_CASE("what the document carries out once in 10 ms of a session costs files and no lease") {
  for_each_kind([&](const google::protobuf::FieldDescriptor& field, const v1::Item& item) {
    const v1::RequestRule* rule = wire::rule_of(item);
    const bool paced = rule != nullptr && rule->cost() == v1::REQUEST_COST_BUILD &&
                       rule->need() != v1::REQUEST_NEED_LEASE;
    CHECK(paced == (field.name().rfind("list_", 0) == 0));
  });
}

}  // namespace
}  // namespace hapticd::test
