// A server on loopback with one device behind it that is led, pushes and calibrates as a test
// wants: what hapticd and a device together are to hapticctl.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/network/udp_transport.h"

namespace hapticd::test {

class DeviceServer {
 public:
  DeviceServer() : transport_("127.0.0.1:0") {
    info.set_driver(v1::DRIVER_HID);
    info.set_port("a test");
    flags = {v1::DEVICE_FLAG_ATTACHED, v1::DEVICE_FLAG_CALIBRATED};
    ServerHost host;
    host.greeting = [] {
      std::vector<v1::Item> items(2);
      items[0].mutable_scene_info()->set_scene_id(1);
      items[0].mutable_scene_info()->set_rate_hz(1000.0);
      items[1].mutable_record_info()->set_state(v1::RECORD_STATE_IDLE);
      return items;
    };
    host.request = [this](const RequestId& id, const v1::Item& item) {
      server_->answer(id, obey(item));
    };
    host.abandoned = [](const RequestId&) {};
    host.fill_state = [this](const Subscription&, v1::State& state) { fill(state); };
    host.lease_lost = [](LeaseEnd) {};
    server_ = std::make_unique<ProtocolServer>(
        ServerOptions{11, false}, host,
        [this](const Address& to, std::span<const std::uint8_t> datagram) {
          transport_.send(to, datagram);
        });
    thread_ = std::thread(
        [this] { transport_.run(*server_, [this](std::int64_t now_ns) { return tick(now_ns); }); });
  }
  ~DeviceServer() {
    transport_.stop();
    thread_.join();
  }
  DeviceServer(const DeviceServer&) = delete;
  DeviceServer& operator=(const DeviceServer&) = delete;

  [[nodiscard]] std::string address() const {
    return "127.0.0.1:" + std::to_string(transport_.port());
  }

  // All that follows is of any thread that holds the mutex.
  std::mutex mutex;
  v1::DeviceInfo info;
  std::vector<v1::DeviceFlag> flags;
  std::array<double, 3> p_DH{};
  v1::LoopState loop_state = v1::LOOP_STATE_READY;
  std::vector<v1::CalibrateStep> steps;  ///< asked for
  std::vector<v1::Axis> pushed;
  std::vector<v1::Axis> confirmed;
  std::string refusal = "The check starts again.";  ///< of what was felt elsewhere
  int engaged = 0, disengaged = 0;
  int held = 0;  ///< measurings that are spoilt by a hand
  /// What GetDeviceInfo tells one after the other; the last one for ever.
  std::vector<v1::CalibrationState> calibration;

 private:
  v1::Result obey(const v1::Item& item) {
    const std::lock_guard lock(mutex);
    v1::Result result;
    result.set_code(v1::RESULT_CODE_OK);
    if (item.has_engage()) {
      ++engaged;
      loop_state = v1::LOOP_STATE_ENGAGED;
    }
    if (item.has_disengage()) {
      ++disengaged;
      loop_state = v1::LOOP_STATE_READY;
    }
    if (item.has_calibrate()) calibrate(item.calibrate(), result);
    if (item.has_get_device_info()) {
      if (!calibration.empty()) info.set_calibration(calibration.front());
      if (calibration.size() > 1) calibration.erase(calibration.begin());
      *result.mutable_devices()->add_devices() = info;
    }
    return result;
  }

  void calibrate(const v1::Calibrate& asked, v1::Result& result) {
    steps.push_back(asked.step());
    if (asked.step() == v1::CALIBRATE_STEP_PUSH) pushed.push_back(asked.axis());
    if (asked.step() == v1::CALIBRATE_STEP_MEASURE) measure(asked.axis(), result);
    if (asked.step() != v1::CALIBRATE_STEP_CONFIRM) return;
    confirmed.push_back(asked.axis());
    if (asked.axis() == pushed.back()) {
      info.add_confirmed(asked.axis());
      info.set_checked(info.confirmed_size() == 6);
    } else {
      info.clear_confirmed();
      result.set_code(v1::RESULT_CODE_FAILED);
      result.set_message(refusal);
    }
  }

  void measure(v1::Axis axis, v1::Result& result) {
    result.set_message("Take the hands off.");
    result.set_code(v1::RESULT_CODE_FAILED);
    if (held-- > 0) return;
    result.set_code(v1::RESULT_CODE_OK);
    result.set_message("At least 0.4 N s/m.");
    info.add_damping()->set_axis(axis);
  }

  void fill(v1::State& state) {
    const std::lock_guard lock(mutex);
    state.set_loop_state(loop_state);
    v1::DeviceState& device = *state.add_devices();
    for (const double p : p_DH) device.add_p_dh_m(p);
    device.add_q_dh(1.0F);
    for (int i = 0; i < 3; ++i) device.add_q_dh(0.0F);
    for (const v1::DeviceFlag flag : flags) device.add_flags(flag);
  }

  bool tick(std::int64_t now_ns) {
    if (now_ns - ticked_ns_ < 1'000'000) return false;
    ticked_ns_ = now_ns;
    server_->offer_tick(tick_++, 1, now_ns);
    return false;
  }

  UdpTransport transport_;
  std::int64_t ticked_ns_ = 0;
  std::uint64_t tick_ = 0;
  std::unique_ptr<ProtocolServer> server_;
  std::thread thread_;
};

}  // namespace hapticd::test
