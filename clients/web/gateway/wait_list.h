// Connections that wait for their peer, in the order in which they began to: when places run out,
// the one that has waited longest gives way. Not RT.
#pragma once

#include <boost/asio/ip/address.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>

namespace hapticd::web {

class WaitList {
 public:
  /// One more, after all others; `give_way` is called once, where it has to, and it is gone from
  /// here before that. Its number, from 1. `now_ns` is of a clock that never goes back.
  std::uint64_t add(const boost::asio::ip::address& from, std::int64_t now_ns,
                    std::function<void()> give_way);
  /// It does not wait any more; 0 and what has gone are nobody.
  void remove(std::uint64_t number);
  /// The one that has waited longest, and since `before_ns` or earlier, gives way, of those that
  /// come from where `of` says, if given. False: there is none.
  bool evict(std::int64_t before_ns,
             const std::function<bool(const boost::asio::ip::address& from)>& of = {});

  [[nodiscard]] std::size_t size() const noexcept { return waiting_.size(); }

 private:
  struct Waiting {
    boost::asio::ip::address from;
    std::int64_t since_ns;
    std::function<void()> give_way;
  };

  std::map<std::uint64_t, Waiting> waiting_;
  std::uint64_t last_ = 0;
};

}  // namespace hapticd::web
