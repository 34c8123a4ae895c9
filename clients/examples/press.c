/* Presses a string and lets it go, in C: poses in, forces and tones out. For a daemon in virtual time with a scripted device:
     hapticd --clock virtual --device scripted
   usage: press [HOST:PORT] */
#include <hapticd_client.h>
#include <math.h>
#include <stdio.h>

enum { TICKS = 600 };

/* Beside the string, down, across it, which plucks it, and up again. */
static void pluck(hapticd_pose* poses) {
  for (int tick = 0; tick < TICKS; ++tick) {
    const double s = (double)tick / (TICKS - 1);
    poses[tick].p_m[0] = 0.0;
    poses[tick].p_m[1] = 0.0153 - 0.0113 * fmin(1.0, 4.0 * fmin(s, 1.0 - s));
    poses[tick].p_m[2] = -0.012 + 0.024 * fmin(1.0, fmax(0.0, 2.0 * s - 0.5));
    poses[tick].q[0] = 1.0;
    poses[tick].q[1] = poses[tick].q[2] = poses[tick].q[3] = 0.0;
  }
}

static int play(hapticd_session* session) {
  hapticd_pose poses[TICKS];
  pluck(poses);
  hapticd_run_result result = {.size = sizeof result};
  int code = hapticd_acquire(session, "press");
  if (code == HAPTICD_OK) code = hapticd_load_scene(session, "single_string");
  if (code == HAPTICD_OK) code = hapticd_subscribe(session, 1);
  if (code == HAPTICD_OK) code = hapticd_run(session, TICKS, poses, TICKS, &result);
  if (code != HAPTICD_OK) return code;

  double largest_n = 0.0;
  for (hapticd_state state = {.size = sizeof state}; hapticd_next_state(session, &state) == 1;) {
    const float* f = state.tools[0].wrench_h_w;
    largest_n = fmax(largest_n, sqrt((double)f[0] * f[0] + (double)f[1] * f[1] + (double)f[2] * f[2]));
  }
  for (hapticd_event event = {.size = sizeof event}; hapticd_next_event(session, &event) == 1;) {
    if (event.kind != HAPTICD_EVENT_TONE) continue;
    printf("string %d sounds at %.2f Hz after %.3f ms\n", event.string_index, (double)event.frequency_hz, (double)event.t_ns * 1e-6);
  }
  printf("%llu ticks, largest force %.4f N, state hash ", (unsigned long long)result.steps, largest_n);
  for (int k = 0; k < 32; ++k) printf("%02x", result.state_hash[k]);
  printf("\n");
  return HAPTICD_OK;
}

int main(int argc, char** argv) {
  hapticd_options options = {.size = sizeof options, .server = argc > 1 ? argv[1] : NULL};
  hapticd_session* session = NULL;
  int code = hapticd_open(&options, &session);
  if (code == HAPTICD_OK) code = play(session);
  if (code != HAPTICD_OK) fprintf(stderr, "press: %s\n", hapticd_last_error(session));
  hapticd_close(session);
  return code == HAPTICD_OK ? 0 : 1;
}
