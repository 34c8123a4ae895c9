// The relay against a broker that is a list.
#include "clients/relay/relay.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "clients/relay/broker.h"

namespace hapticd::test {
namespace {

using relay::Publication;

TEST_CASE("each kind of Item has its topic; requests, answers and pieces have none") {
  std::vector<Publication> published;
  relay::Relay relay("p", [&](const Publication& each) {
    published.push_back(each);
    return true;
  });
  std::vector<v1::Item> items(7);
  items[0].mutable_contact();
  items[1].mutable_string_radius();
  items[2].mutable_fault();
  items[3].mutable_lease_info();
  items[4].mutable_record_info();
  items[5].mutable_result();
  items[6].mutable_chunk();
  for (const v1::Item& item : items) relay.item(item);
  std::vector<std::string> topics;
  topics.reserve(published.size());
  for (const Publication& each : published) topics.push_back(each.topic);
  CHECK(topics ==
        std::vector<std::string>{"p/contact", "p/string", "p/fault", "p/lease", "p/record"});
  CHECK_FALSE(published[0].retained);
  CHECK(published[2].retained);
  CHECK(published[0].qos == 1);
  CHECK(relay::publication_of("p", v1::State()).qos == 0);
}

TEST_CASE("a prefix is a topic that one can publish to, as MQTT 3.1.1 has it in section 4.7") {
  for (const std::string good : {"hapticd", "stage/one", "/", "Bühne/eins", "a b"}) {
    CHECK(relay::prefix_problem(good).empty());
  }
  using namespace std::string_literals;
  for (const std::string& bad : {""s, "#"s, "a/#/b"s, "a+"s, "a\0b"s, "\xff"s, "a\xc3"s, "a\nb"s,
                                 std::string(65'536, 'a')}) {
    CAPTURE(bad.substr(0, 10));
    CHECK_FALSE(relay::prefix_problem(bad).empty());
  }
}

}  // namespace
}  // namespace hapticd::test
