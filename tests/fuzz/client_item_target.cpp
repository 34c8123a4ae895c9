// See client_item_target.h.
#include "tests/fuzz/client_item_target.h"

#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "clients/ctl/connection.h"
#include "clients/ctl/device_text.h"
#include "clients/ctl/view.h"
#include "clients/library/client_core.h"
#include "proto/wire/shown_text.h"
#include "tests/fuzz/plain_line.h"

namespace hapticd::test {
namespace {

using View = std::span<const std::uint8_t>;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint32_t kBootId = 5;
/// Datagrams in one input: more only cost time.
constexpr int kMaxDatagrams = 64;
/// Parts of a State, at most.
constexpr std::size_t kMaxParts = 32;
/// A number below 0 that came in five bytes leaves in ten.
constexpr std::size_t kWidening = 2;

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

void require_plain(const std::string& text) {
  require(is_plain_line(text), "something is shown that a terminal obeys");
}

/// Columns of a line in UTF-8 are no more than its bytes.
void check_screen(const ctl::View& view, std::size_t columns, std::size_t rows) {
  const std::vector<std::string> lines = ctl::screen_lines(view, columns, rows);
  require(lines.size() <= rows, "a screen with more lines than it has");
  for (const std::string& line : lines) {
    require_plain(line);
    require(line.size() <= columns, "a line that does not fit");
  }
}

/// All that hapticctl makes of a Result.
void show(const v1::Result& result) {
  try {
    ctl::require(result);
  } catch (const ctl::Failure& failure) {
    require(is_plain_line(wire::shown_lines(failure.what()), true), "a refusal is not plain");
    require(failure.exit_code() == ctl::kRefused || failure.exit_code() == ctl::kUnreachable,
            "an exit code of something else");
  }
  require_plain(ctl::network_line(result.counts()));
  for (const v1::DeviceInfo& info : result.devices().devices()) {
    for (const std::string& line : ctl::info_lines(info)) require_plain(wire::shown_text(line));
    require_plain(wire::shown_text(ctl::unchecked_text(info) + ctl::no_force_text(info)));
  }
}

/// A client as hapticctl has one, and the server's side of its session.
class FuzzedClient {
 public:
  FuzzedClient()
      : core_([](View datagram) { check_sent(datagram); }, [this] { return ++random_; },
              handlers()) {
    v1::Item item;
    item.mutable_subscribe()->set_divisor(1);
    ask(item);
    item.mutable_get_counts();
    ask(item);
    item.mutable_get_device_info();
    ask(item);
    item.mutable_load_scene()->set_text(std::string(3000, '#'));
    ask(item);
    item.mutable_pose_batch()->add_poses();
    core_.request(item);
    core_.poll(now_ns_);
  }

  void receive(View bytes, unsigned head) {
    if ((head & 0x2000U) != 0) pass(200 * kMs);
    if ((head & 0x1000U) != 0) pass(11'000 * kMs);
    if ((head & 0x0800U) != 0) {
      v1::Item item;
      item.mutable_ping();
      ask(item);
    }
    std::string datagram(bytes.begin(), bytes.end());
    if ((head & 0x8000U) != 0) datagram = with_header(datagram, (head & 0x4000U) != 0);
    came_ += datagram.size();
    core_.receive({reinterpret_cast<const std::uint8_t*>(datagram.data()), datagram.size()},
                  now_ns_);
    pass(kMs);
    require(core_.refusal().size() <= wire::kMessageBytes, "a long refusal");
    require_plain(wire::shown_text(core_.refusal()));
  }

  [[nodiscard]] bool finish() {
    for (const std::size_t columns : {std::size_t{20}, std::size_t{200}}) {
      check_screen(view_, columns, 24);
    }
    for (const std::string& line : ctl::summary_lines(view_)) require_plain(line);
    for (const std::string& line : ctl::reading_lines(view_.state, std::nullopt)) {
      require_plain(wire::shown_text(line));
    }
    core_.leave(now_ns_);
    for (int k = 0; k < 20 && !core_.over(); ++k) pass(200 * kMs);
    require(core_.over(), "a client cannot leave");
    require(waiting_ == 0, "a request has no answer");
    return heard_ > 0;
  }

 private:
  void ask(const v1::Item& item) {
    ++waiting_;
    const std::uint64_t id =
        core_.request(item, [this, answered = false](const auto* result) mutable {
          require(!std::exchange(answered, true), "a request has two answers");
          --waiting_;
          if (result == nullptr) return;
          ++heard_;
          require(result->ByteSizeLong() <= kWidening * came_, "a Result that never came");
          show(*result);
        });
    if (id == 0) --waiting_;
  }

  client::ClientHandlers handlers() {
    client::ClientHandlers made;
    made.item = [this](const v1::Item& item) {
      ++heard_;
      require(item.ByteSizeLong() <= kWidening * came_, "an Item that never came");
      if (item.has_scene_info()) view_.scene = item.scene_info();
      if (item.has_lease_info()) view_.lease = item.lease_info();
      if (item.has_tone()) view_.tones.push_front(item.tone());
      if (view_.tones.size() > 5) view_.tones.pop_back();
    };
    made.state = [this](const v1::State& state) {
      ++heard_;
      require(state.ByteSizeLong() <= kWidening * kMaxParts * wire::kDatagramBytes,
              "a State of too many parts");
      view_.state = state;
      view_.has_state = true;
    };
    made.pose_refused = [this](const v1::Result& result) {
      ++heard_;
      show(result);
    };
    made.ended = [this](client::SessionEnd) {
      v1::Item item;
      item.mutable_ping();
      ask(item);
    };
    return made;
  }

  static void check_sent(View bytes) {
    const auto header = wire::decode_header(bytes);
    require(header.has_value() && header->kind == wire::DatagramKind::kPlain, "no datagram");
    v1::Packet packet;
    require(wire::parse_packet(bytes.subspan(wire::kHeaderBytes), packet), "no Packet");
  }

  /// The datagram of the session with this body.
  std::string with_header(std::string body, bool awaited) {
    if (session_ != core_.session()) next_id_ = 1;
    session_ = core_.session();
    const google::protobuf::LogSilencer silence;
    v1::Packet packet;
    if (awaited && packet.ParseFromString(body)) {
      packet.set_boot_id(kBootId);
      packet.set_first(next_id_);
      next_id_ += static_cast<std::uint64_t>(packet.items_size());
      body = packet.SerializeAsString();
    }
    const auto header = wire::encode_header({wire::DatagramKind::kPlain, session_, counter_++});
    return std::string(header.begin(), header.end()) + body;
  }

  void pass(std::int64_t ns) {
    now_ns_ += ns;
    core_.poll(now_ns_);
  }

  std::int64_t now_ns_ = 1000 * kMs;
  std::uint32_t random_ = 0;
  std::uint64_t counter_ = 0;
  std::uint32_t session_ = 0;
  std::uint64_t next_id_ = 1;  ///< of the server's Items
  std::size_t came_ = 0;       ///< bytes
  int waiting_ = 0;            ///< requests
  int heard_ = 0;
  ctl::View view_;
  client::ClientCore core_;
};

}  // namespace

bool check_client_items(View bytes) {
  FuzzedClient client;
  for (int n = 0; n < kMaxDatagrams && bytes.size() >= 2; ++n) {
    const unsigned head = bytes[0] | static_cast<unsigned>(bytes[1]) << 8U;
    bytes = bytes.subspan(2);
    const auto datagram = bytes.first(std::min<std::size_t>(head & 0x7ffU, bytes.size()));
    bytes = bytes.subspan(datagram.size());
    client.receive(datagram, head);
  }
  return client.finish();
}

}  // namespace hapticd::test
