// A session over a virtual network with traffic both ways, every datagram of it captured: what an
// attacker on the way has.
#pragma once

#include <optional>

#include "tests/clients/library/virtual_network.h"

namespace hapticd::test {

struct CapturedSession {
  VirtualNetwork network;
  VirtualClient* mine = nullptr;

  explicit CapturedSession(const ServerOptions& options = {.boot_id = 7},
                           const std::optional<client::ClientKey>& key = std::nullopt)
      : network(options) {
    network.capturing = true;
    network.tick_each_step = true;
    LinkConditions conditions;
    conditions.delay_ns = kTestMillisecond_ns;
    conditions.jitter_ns = 3 * kTestMillisecond_ns;
    conditions.loss = 0.1;
    mine = &network.add_client(conditions, 3, key);
    v1::Item acquire;
    acquire.mutable_acquire()->set_holder("mine");
    mine->core->request(acquire);
    v1::Item subscribe;
    subscribe.mutable_subscribe()->set_divisor(20);
    mine->core->request(subscribe);
    network.run_until(kTestSecond_ns, [this] { return network.server->session_count() == 1; });
    for (std::uint32_t i = 0; i < 100; ++i) {
      network.server->broadcast(tone_item(i));
      mine->core->request(numbered_request(i));
      network.run_for(2 * kTestMillisecond_ns);
    }
    // At the end nothing is lost: sent again, a State that never arrived would be news.
    mine->to_server.set_conditions({});
    mine->to_client.set_conditions({});
    network.run_for(kTestSecond_ns);
    network.capturing = false;
    network.tick_each_step = false;
  }
};

}  // namespace hapticd::test
