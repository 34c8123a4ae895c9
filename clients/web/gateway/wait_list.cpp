// See wait_list.h.
#include "clients/web/gateway/wait_list.h"

#include <algorithm>
#include <utility>

namespace hapticd::web {

std::uint64_t WaitList::add(const boost::asio::ip::address& from, std::int64_t now_ns,
                            std::function<void()> give_way) {
  waiting_[++last_] = {from, now_ns, std::move(give_way)};
  return last_;
}

void WaitList::remove(std::uint64_t number) { waiting_.erase(number); }

bool WaitList::evict(std::int64_t before_ns,
                     const std::function<bool(const boost::asio::ip::address&)>& of) {
  const auto found = std::find_if(waiting_.begin(), waiting_.end(),
                                  [&](const auto& each) { return !of || of(each.second.from); });
  if (found == waiting_.end() || found->second.since_ns > before_ns) return false;
  const std::function<void()> give_way = std::move(found->second.give_way);
  waiting_.erase(found);
  give_way();
  return true;
}

}  // namespace hapticd::web
