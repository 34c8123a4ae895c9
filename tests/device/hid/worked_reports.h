// The worked reports of PROFILE.md, section 11: bytes put together by hand from its tables, and
// what they mean, written down as numbers. Neither comes from the codec.
#pragma once

#include <array>
#include <cstdint>

#include "device/hid/profile_v1.h"

namespace hapticd::test {

inline constexpr std::array<std::uint8_t, 64> kStateBytes{
    0x01, 0x07, 0x34, 0x12, 0x40, 0x42, 0x0F, 0x00, 0x80, 0x96, 0x98, 0x00, 0xC0, 0xB4, 0xB3, 0xFF,
    0x01, 0x00, 0x00, 0x00, 0xCD, 0x3C, 0x41, 0x2D, 0xCD, 0x3C, 0x41, 0x2D, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0xE8, 0x03, 0xFF, 0xFF, 0x00, 0x00, 0x00, 0x00, 0xF4, 0x01, 0x0C, 0xFE,
    0xD2, 0x04, 0xEC, 0xFF, 0x03, 0x00, 0xFF, 0x00, 0x69, 0x00, 0x00, 0x00, 0x2D, 0x80, 0x00, 0x00};
inline constexpr hid::StateReport kState{.status = 7,
                                         .seq = 0x1234,
                                         .t_us = 1'000'000,
                                         .pos_nm = {10'000'000, -5'000'000, 1},
                                         .quat_q30 = {759'250'125, 759'250'125, 0, 0},
                                         .vel_100ums = {1000, -1, 0},
                                         .avel_mradps = {0, 500, -500},
                                         .grip_10um = 1234,
                                         .grip_vel_mmps = -20,
                                         .buttons = 3,
                                         .cmd_seq = 255,
                                         .cmd_age = 105,
                                         .fault = 0,
                                         .temp_deg_c = 45,
                                         .load = 128};

inline constexpr std::array<std::uint8_t, 32> kCommandBytes{
    0x02, 0x09, 0x00, 0x01, 0x60, 0xE3, 0x16, 0x00, 0x70, 0x2F, 0xFC, 0xFF, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x10, 0x27, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0x2C, 0x01, 0x34, 0x12};
inline constexpr hid::CommandReport kCommand{.flags = 9,
                                             .seq = 256,
                                             .force_un = {1'500'000, -250'000, 0},
                                             .torque_unm = {0, 10'000, -1},
                                             .grip_mn = 300,
                                             .ref_seq = 0x1234};

inline constexpr std::array<std::uint8_t, 64> kAffineBytes{
    0x03, 0x01, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x34, 0x12,
    0xF4, 0x01, 0xF4, 0x01, 0x20, 0x03, 0x00, 0x00, 0x9C, 0xFF, 0x00, 0x00, 0xD0, 0x07, 0xD0, 0x07,
    0xD0, 0x07, 0x32, 0x00, 0x32, 0x00, 0x32, 0x00, 0x64, 0x00, 0x64, 0x00, 0x64, 0x00, 0x00, 0x00};
inline constexpr hid::AffineReport kAffine{.base = {.flags = 1, .seq = 257, .ref_seq = 0x1234},
                                           .k_npm = {500, 500, 800, 0, -100, 0},
                                           .b_mnspm = {2000, 2000, 2000},
                                           .kr_mnmprad = {50, 50, 50},
                                           .br_10unmsprad = {100, 100, 100}};

inline constexpr std::array<std::uint8_t, 64> kCapabilitiesBytes{
    0x10, 0x01, 0x00, 0x02, 0x48, 0x41, 0x50, 0x31, 0x63, 0x00, 0x00, 0x00, 0xFF, 0x3F, 0xE8, 0x03,
    0x40, 0x1F, 0x14, 0x00, 0x64, 0x00, 0x2C, 0x01, 0x84, 0x03, 0x64, 0x00, 0x2C, 0x01, 0xB8, 0x0B,
    0x9C, 0xFF, 0xB5, 0xFF, 0xC4, 0xFF, 0x64, 0x00, 0x4B, 0x00, 0x3C, 0x00, 0xDC, 0x05, 0xDC, 0x05,
    0x46, 0x0C, 0x88, 0x13, 0x00, 0x00, 0x64, 0x00, 0x00, 0x00, 0x78, 0x00, 0xB8, 0x0B, 0x00, 0x00};
inline constexpr hid::Capabilities kCapabilities{.ver_major = 1,
                                                 .ver_minor = 0,
                                                 .n_buttons = 2,
                                                 .caps = 0x63,
                                                 .dof = 0x3FFF,
                                                 .in_rate_hz = 1000,
                                                 .servo_rate_hz = 8000,
                                                 .wd_default_ms = 20,
                                                 .wd_max_ms = 100,
                                                 .f_cont_cn = 300,
                                                 .f_peak_cn = 900,
                                                 .tau_cont_mnm = 100,
                                                 .tau_peak_mnm = 300,
                                                 .k_max_npm = 3000,
                                                 .ws_min_mm = {-100, -75, -60},
                                                 .ws_max_mm = {100, 75, 60},
                                                 .rot_range_mrad = {1500, 1500, 3142},
                                                 .pos_res_nm = 5000,
                                                 .rot_res_urad = 100,
                                                 .mass_g = 120,
                                                 .grip_range = 3000};

inline constexpr std::array<std::uint8_t, 16> kConfigBytes{
    0x11, 0x00, 0x0A, 0x00, 0x90, 0x01, 0x96, 0x00, 0xDC, 0x05, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00};
inline constexpr hid::Config kConfig{
    .wd_ms = 10, .f_cap_cn = 400, .tau_cap_mnm = 150, .v_cap_mmps = 1500, .grav_comp = 0};

inline constexpr std::array<std::uint8_t, 8> kCalibrationBytes{0x12, 0x01, 0x02, 0x64,
                                                               0x7F, 0x00, 0x00, 0x00};
inline constexpr hid::Calibration kCalibration{.op = hid::CalibrationOp::kStart,
                                               .state = hid::CalibrationState::kOk,
                                               .progress = 100,
                                               .axis_mask = 0x7F};

}  // namespace hapticd::test
