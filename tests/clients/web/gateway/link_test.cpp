// What is said about a link: every case of the table in link_verdict.h, and the meter against
// losses that were counted by hand.
#include <doctest/doctest.h>

#include <cerrno>
#include <initializer_list>
#include <set>

#include "clients/web/gateway/link_meter.h"
#include "clients/web/gateway/link_verdict.h"

namespace hapticd::test {
namespace {

using web::judge;
using web::LinkFacts;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

LinkFacts fresh() {
  LinkFacts facts;
  facts.server = "10.0.0.2:47800";
  facts.began_ns = 100 * kSecond_ns;
  return facts;
}

LinkFacts heard_at(std::int64_t heard_ns) {
  LinkFacts facts = fresh();
  facts.heard_ns = heard_ns;
  return facts;
}

LinkFacts troubled(int error, std::int64_t at_ns) {
  LinkFacts facts = fresh();
  facts.trouble = error;
  facts.trouble_ns = at_ns;
  return facts;
}

TEST_CASE("each way to fail has a state of its own, and words that name the remedy") {
  const std::int64_t now_ns = 110 * kSecond_ns;
  LinkFacts wrong_key = fresh();
  wrong_key.keyed = true;
  LinkFacts other = fresh();
  other.other_major = 2;
  other.other_major_ns = now_ns;
  const auto no_route = judge(troubled(ENETUNREACH, now_ns), now_ns);
  const auto refused = judge(troubled(ECONNREFUSED, now_ns), now_ns);
  const auto key = judge(wrong_key, now_ns);
  const auto no_key = judge(fresh(), now_ns);
  const auto version = judge(other, now_ns);
  const auto silence = judge(heard_at(104 * kSecond_ns), now_ns);
  CHECK(no_route.state == v1::PAGE_LINK_STATE_NO_ROUTE);
  CHECK(refused.state == v1::PAGE_LINK_STATE_DAEMON_GONE);
  CHECK(key.state == v1::PAGE_LINK_STATE_WRONG_KEY);
  CHECK(no_key.state == v1::PAGE_LINK_STATE_WRONG_KEY);
  CHECK(version.state == v1::PAGE_LINK_STATE_VERSION_MISMATCH);
  CHECK(silence.state == v1::PAGE_LINK_STATE_SILENT);
  CHECK(silence.message.find("6 s") != std::string::npos);
  CHECK(key.message.find("view.key") != std::string::npos);
  CHECK(no_key.message.find("--key") != std::string::npos);
  CHECK(refused.message.find("Start hapticd") != std::string::npos);
  CHECK(version.message.find("major 2") != std::string::npos);
  std::set<std::string> messages;
  for (const auto& each : {no_route, refused, key, no_key, version, silence}) {
    CHECK(each.message.find("10.0.0.2:47800") != std::string::npos);
    CHECK(each.message.size() <= 400);
    messages.insert(each.message);
  }
  CHECK(messages.size() == 6);
}

TEST_CASE("while a daemon is heard it is live, whatever the system said before") {
  LinkFacts facts = troubled(ECONNREFUSED, 109 * kSecond_ns);
  facts.heard_ns = 110 * kSecond_ns;
  CHECK(judge(facts, 110 * kSecond_ns).state == v1::PAGE_LINK_STATE_LIVE);
  CHECK(judge(facts, 110 * kSecond_ns).message.empty());
}

TEST_CASE("a daemon that says goodbye is gone at once, one that is heard again is not") {
  LinkFacts facts = heard_at(110 * kSecond_ns);
  facts.said_bye = true;
  facts.bye_message = "the end";
  const auto gone = judge(facts, 110 * kSecond_ns);
  CHECK(gone.state == v1::PAGE_LINK_STATE_DAEMON_GONE);
  CHECK(gone.message.find("the end") != std::string::npos);
  facts.said_bye = false;
  CHECK(judge(facts, 110 * kSecond_ns).state == v1::PAGE_LINK_STATE_LIVE);
}

TEST_CASE("a first answer may take two seconds, and is not called silence before") {
  CHECK(judge(fresh(), 101 * kSecond_ns).state == v1::PAGE_LINK_STATE_CONNECTING);
  CHECK(judge(fresh(), 102 * kSecond_ns).state != v1::PAGE_LINK_STATE_CONNECTING);
}

TEST_CASE("what the system said is forgotten when it does not say it again") {
  const LinkFacts facts = troubled(ENETUNREACH, 105 * kSecond_ns);
  CHECK(judge(facts, 106 * kSecond_ns).state == v1::PAGE_LINK_STATE_NO_ROUTE);
  CHECK(judge(facts, 108 * kSecond_ns).state == v1::PAGE_LINK_STATE_WRONG_KEY);
}

TEST_CASE("an unknown name and a full daemon say what they are") {
  LinkFacts unknown = troubled(0, 110 * kSecond_ns);
  unknown.unknown_name = true;
  const auto name = judge(unknown, 110 * kSecond_ns);
  CHECK(name.state == v1::PAGE_LINK_STATE_NO_ROUTE);
  CHECK(name.message.find("no machine called") != std::string::npos);
  LinkFacts full = heard_at(110 * kSecond_ns);
  full.full = true;
  CHECK(judge(full, 110 * kSecond_ns).message.find("32 clients") != std::string::npos);
}

TEST_CASE("the meter counts lost datagrams by their counters, and bytes by the second") {
  web::LinkMeter meter;
  (void)meter.roll(kSecond_ns);
  for (std::uint64_t counter = 0; counter < 100; ++counter) {
    if (counter % 5 == 2) continue;  // 20 of 100 are lost
    const wire::DatagramHeader header{wire::DatagramKind::kPlain, 7, counter};
    meter.take(&header, 500);
  }
  const auto quality = meter.roll(3 * kSecond_ns);
  CHECK(quality.loss == doctest::Approx(0.2));
  CHECK(quality.bytes_per_s == doctest::Approx(80 * 500 / 2.0));
  CHECK(meter.total_bytes() == 40'000);
  CHECK(meter.roll(4 * kSecond_ns).loss == 0.0);
}

TEST_CASE("another session, or datagrams that overtake each other, are no loss") {
  web::LinkMeter meter;
  (void)meter.roll(kSecond_ns);
  for (const std::uint64_t counter : {901U, 900U, 903U, 902U}) {
    const wire::DatagramHeader header{wire::DatagramKind::kPlain, 7, counter};
    meter.take(&header, 100);
  }
  const wire::DatagramHeader next{wire::DatagramKind::kPlain, 8, 0};
  meter.take(&next, 100);
  CHECK(meter.roll(2 * kSecond_ns).loss == 0.0);
}

TEST_CASE("what is lost is counted within a session, up to the highest counter that came") {
  const auto loss_of = [](std::initializer_list<wire::DatagramHeader> headers) {
    web::LinkMeter meter;
    for (const wire::DatagramHeader& header : headers) meter.take(&header, 100);
    return meter.roll(kSecond_ns).loss;
  };
  constexpr auto kPlain = wire::DatagramKind::kPlain;
  // 902, 903 and 904 never came, though 901 came last.
  CHECK(loss_of({{kPlain, 7, 900}, {kPlain, 7, 905}, {kPlain, 7, 901}}) == doctest::Approx(0.5));
  // A session that begins at 50 has lost 51 and nothing before.
  CHECK(loss_of({{kPlain, 7, 900}, {kPlain, 8, 50}, {kPlain, 8, 52}, {kPlain, 8, 53}}) ==
        doctest::Approx(0.25));
}

}  // namespace
}  // namespace hapticd::test
