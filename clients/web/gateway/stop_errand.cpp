// See stop_errand.h.
#include "clients/web/gateway/stop_errand.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "proto/wire/request_result.h"

namespace hapticd::web {
namespace {

/// How long the road is tried before the session.
constexpr std::chrono::milliseconds kPatience{500};

}  // namespace

class StopErrand::Implementation {
 public:
  Implementation(boost::asio::io_context& context, client::StopPlace place,
                 std::function<void(client::ResultHandler)> otherwise)
      : context_(context), place_(std::move(place)), otherwise_(std::move(otherwise)) {}
  ~Implementation() {
    if (thread_.joinable()) thread_.join();
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

 private:
  friend StopErrand;

  void start() {
    waiting_ = std::exchange(later_, {});
    thread_ = std::thread([this, place = place_] {
      const client::StopReport report = client::stop_by_road(place, kPatience);
      boost::asio::post(context_, [this, report] { finish(report); });
    });
  }

  void finish(const client::StopReport& report) {
    thread_.join();
    for (client::ResultHandler& done : std::exchange(waiting_, {})) {
      if (!report.stopped) {
        otherwise_(std::move(done));
      } else if (done) {
        const v1::Result result = wire::result_of(v1::RESULT_CODE_OK);
        done(&result);
      }
    }
    if (!later_.empty()) start();
  }

  boost::asio::io_context& context_;
  client::StopPlace place_;
  std::function<void(client::ResultHandler)> otherwise_;
  std::vector<client::ResultHandler> waiting_;  ///< for the one under way
  /// For the next: after a Clear, the one under way is no Stop of theirs.
  std::vector<client::ResultHandler> later_;
  std::thread thread_;  ///< joinable: one is under way
};

StopErrand::StopErrand(boost::asio::io_context& context, client::StopPlace place,
                       std::function<void(client::ResultHandler)> otherwise)
    : implementation_(
          std::make_unique<Implementation>(context, std::move(place), std::move(otherwise))) {}

StopErrand::~StopErrand() = default;

void StopErrand::look_at(std::uint16_t port) { implementation_->place_.port = port; }

void StopErrand::run(client::ResultHandler done) {
  Implementation& mine = *implementation_;
  if (mine.place_.port == 0) {
    mine.otherwise_(std::move(done));
    return;
  }
  mine.later_.push_back(std::move(done));
  if (!mine.thread_.joinable()) mine.start();
}

}  // namespace hapticd::web
