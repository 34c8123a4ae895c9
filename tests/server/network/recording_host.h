// The host of a ProtocolServer in tests: it records what it is asked, and answers OK at once or
// later. Shared by the tests that write datagrams by hand and by those with real clients.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "server/network/protocol_server.h"

namespace hapticd::test {

/// A Result with this code.
inline v1::Result result_with(v1::ResultCode code = v1::RESULT_CODE_OK) {
  v1::Result result;
  result.set_code(code);
  return result;
}

/// SceneInfo and RecordInfo, as short as they may be.
inline std::vector<v1::Item> usual_greeting() {
  std::vector<v1::Item> items(2);
  items[0].mutable_scene_info()->set_scene_id(1);
  items[1].mutable_record_info()->set_state(v1::RECORD_STATE_IDLE);
  return items;
}

struct RecordingHost {
  struct Asked {
    RequestId id;
    v1::Item item;
  };

  /// Its functions; `answer` reaches the server.
  ServerHost functions(const std::function<void(const RequestId&, v1::Result)>& answer) {
    ServerHost host;
    host.greeting = [this] { return greeting; };
    host.request = [this, answer](const RequestId& id, const v1::Item& item) {
      asked.push_back({id, item});
      if (works) works();
      deepest = std::max(deepest, ++depth);
      if (answers) answer(id, result_with());
      --depth;
    };
    host.abandoned = [this, answer](const RequestId& id) {
      abandoned.push_back(id);
      answer(id, result_with());  // as the daemon does of a Run; nobody wants it any more
    };
    host.fill_state = [this](const Subscription& subscription, v1::State& state) {
      subscriptions.push_back(subscription);
      if (fill) fill(subscription, state);
    };
    host.lease_lost = [this](LeaseEnd how) { lease_ends.push_back(how); };
    host.session = [this](const SessionNotice& notice) { notices.push_back(notice); };
    return host;
  }

  std::function<void()> works;  ///< while a request is carried out
  std::vector<v1::Item> greeting = usual_greeting();
  bool answers = true;
  int depth = 0;    ///< requests under way, one inside the other
  int deepest = 0;  ///< most of them
  std::function<void(const Subscription&, v1::State&)> fill;
  std::vector<Asked> asked;
  std::vector<RequestId> abandoned;
  std::vector<LeaseEnd> lease_ends;
  std::vector<SessionNotice> notices;
  std::vector<Subscription> subscriptions;  ///< of the States it filled
};

}  // namespace hapticd::test
