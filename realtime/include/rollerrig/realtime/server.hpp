// realtime/server.hpp - the loop: one period of the rig after the other, each at its deadline or at its command.
//
//   deadline k -> sensors of t_k are sent -> commands that have arrived -> [gate, watchdog] -> what acts -> plant to t_k+1
//
// In real time a command acts from the deadline after its arrival on. In lock-step there are no deadlines: the loop waits for the
// command that answers the sensors just sent; the controller then has no delay, and the run is the same on any machine.
//
// The loop allocates nothing and makes no system call but those of its port and its clock. Everything it needs is given:
//   Plant  std::size_t of outputs(); read(span out); bool step(span commands): false at its end, and where it leaves its validity
//   Port   receive(span buffer, Peer&) -> bytes, -1: nothing there;  send(span frame, Peer);  wait(nanoseconds)
//   Clock  now() [ns];  sleep_until(ns)
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rollerrig/realtime/command_gate.hpp"
#include "rollerrig/realtime/settings.hpp"
#include "rollerrig/realtime/statistics.hpp"

namespace rollerrig::realtime {

enum class Ending : int { ran = 0, stopped_by_caller, plant_ended, controller_silent };

/// Applied commands and sensors of each period, in memory taken before the run.
struct Record {
  std::size_t inputs{}, outputs{};
  std::vector<double> commands, sensors;  ///< row by row; sensors have one row more: those of the start
  std::size_t periods{0};

  void take_room(std::size_t in, std::size_t out, std::size_t most) {
    inputs = in, outputs = out;
    commands.assign(in * most, 0.0);  // written now: no page is missing later
    sensors.assign(out * (most + 1), 0.0);
  }
  bool taken() const { return !sensors.empty(); }
};

template <class Plant, class Port, class Clock>
class Server {
 public:
  Server(Plant& plant, Port& port, Clock& clock, std::vector<Input> inputs, std::string description,
         ServerSettings settings)
      : plant_{plant},
        port_{port},
        clock_{clock},
        settings_{settings},
        period_{settings.period_ns()},
        give_up_{std::llround(1e9 * settings.give_up)},
        gate_{inputs, static_cast<std::uint32_t>(settings.session),
              settings.lock_step ? 0u : static_cast<std::uint32_t>(settings.oldest)},
        watchdog_{std::move(inputs), settings.patience, settings.ramp},
        description_{std::move(description)},
        sensors_(plant.outputs()) {
    if (settings_.record)
      record_.take_room(watchdog_.inputs().size(), sensors_.size(), static_cast<std::size_t>(settings_.periods));
  }

  Ending run() {
    if (settings_.at_once) watchdog_.run_without();
    std::int64_t deadline = clock_.now();
    plant_.read(sensors_);
    keep_sensors();
    Ending ending = Ending::ran;
    for (std::int64_t done = 0; done < settings_.periods;) {
      if (stop_.load(std::memory_order_relaxed)) {
        ending = Ending::stopped_by_caller;
        break;
      }
      if (!settings_.lock_step) {
        clock_.sleep_until(deadline);
        statistics_.wake.add(clock_.now() - deadline);
      }
      std::int64_t begun = clock_.now();
      send_sensors(static_cast<std::uint16_t>(watchdog_.state()));
      if (settings_.lock_step && !settings_.at_once) {
        if (!await_command()) {
          ending = stop_.load(std::memory_order_relaxed) ? Ending::stopped_by_caller : Ending::controller_silent;
          break;
        }
        begun = clock_.now();
      }
      if (!settings_.lock_step) receive_all();
      std::span<double const> const acting = watch();
      if (watchdog_.state() == Watchdog::waiting) {
        statistics_.waited.add();
        deadline += period_;
        continue;
      }
      bool const goes_on = advance(acting, ++done);
      deadline = account(begun, deadline);
      if (!goes_on) {
        ending = Ending::plant_ended;
        break;
      }
    }
    statistics_.state.store(RR_ENDED, std::memory_order_relaxed);
    send_sensors(RR_ENDED);
    return ending;
  }

  void stop() { stop_.store(true, std::memory_order_relaxed); }
  Statistics const& statistics() const { return statistics_; }
  CommandGate const& gate() const { return gate_; }
  Record const& recorded() const { return record_; }

 private:
  static constexpr int most_frames = 64;                    ///< looked at in one period, whatever arrives
  static constexpr std::int64_t resend_after{500'000'000};  ///< [ns]

  bool advance(std::span<double const> acting, std::int64_t done) {
    if (record_.taken())
      std::copy(acting.begin(), acting.end(),
                record_.commands.begin() + static_cast<std::ptrdiff_t>(record_.periods * record_.inputs));
    bool const goes_on = plant_.step(acting);
    plant_.read(sensors_);
    time_ = done * period_;
    statistics_.periods.add();
    statistics_.time.set(static_cast<std::uint64_t>(time_));
    if (record_.taken()) ++record_.periods;
    keep_sensors();
    return goes_on;
  }

  void keep_sensors() {
    if (!record_.taken()) return;
    auto const at = static_cast<std::ptrdiff_t>(record_.periods * record_.outputs);
    std::copy(sensors_.begin(), sensors_.end(), record_.sensors.begin() + at);
  }

  /// The next deadline; those that have passed meanwhile are given up: the rig is late then, and does not hurry after them.
  std::int64_t account(std::int64_t begun, std::int64_t deadline) {
    std::int64_t const now = clock_.now();
    statistics_.step.add(now - begun);
    if (settings_.lock_step) return now;
    std::int64_t const next = deadline + period_;
    if (now <= next) return next;
    statistics_.misses.add();
    std::int64_t const over = (now - next) / period_;
    statistics_.skipped.add(static_cast<std::uint64_t>(over));
    return next + over * period_;
  }

  std::span<double const> watch() {
    auto const fresh = std::exchange(fresh_, false) ? gate_.command() : std::span<double const>{};
    bool const had_command = watchdog_.state() != Watchdog::waiting;
    auto const acting = watchdog_.step(fresh, (gate_.header().flags & RR_REARM) != 0);
    if (statistics_.trips.get() == 0 && watchdog_.trips() > 0) statistics_.first_trip.set(statistics_.time.get());
    statistics_.trips.set(static_cast<std::uint64_t>(watchdog_.trips()));
    auto const silent = static_cast<std::uint64_t>(watchdog_.silent());
    statistics_.silent.set(silent);
    if (had_command) statistics_.longest_silent.set(std::max(silent, statistics_.longest_silent.get()));
    statistics_.state.store(watchdog_.state(), std::memory_order_relaxed);
    if (watchdog_.silent() >= settings_.patience) gate_.give_up_peer();
    return acting;
  }

  void receive_all() {
    for (int i = 0; i < most_frames && receive_one(); ++i) {
    }
  }

  /// Takes one frame if there is one.
  bool receive_one() {
    Peer sender = 0;
    std::ptrdiff_t const size = port_.receive(buffer_, sender);
    if (size < 0) return false;
    auto const frame = std::span<unsigned char const>(buffer_).first(static_cast<std::size_t>(size));
    Verdict const verdict = gate_.judge(frame, sender, sequence_);
    if (verdict == Verdict::accepted) fresh_ = true;
    if (verdict == Verdict::asked) send_description(gate_.header().answers, sender);
    if (verdict == Verdict::refused) send_part({}, 0, 0, sender);
    return true;
  }

  /// Lock-step: until the command is there; false where the caller stops the run or the controller is silent. A datagram may be
  /// lost: after some time the sensors are sent again.
  bool await_command() {
    std::int64_t const begun = clock_.now();
    std::int64_t sent = begun;
    while (!fresh_) {
      if (stop_.load(std::memory_order_relaxed)) return false;
      if (!receive_one()) port_.wait(20'000'000);
      std::int64_t const now = clock_.now();
      if (gate_.counted(Verdict::accepted) > 0 && now - begun > give_up_) return false;
      if (!std::exchange(asked_, false) && now - sent < resend_after) continue;
      send_sensors(static_cast<std::uint16_t>(watchdog_.state()));
      sent = now;
    }
    return true;
  }

  void send_sensors(std::uint16_t state) {
    if (gate_.peer() == 0) return;
    rr_header header{};
    header.kind = RR_SENSORS;
    header.session = static_cast<std::uint32_t>(settings_.session);
    header.sequence = ++sequence_;
    header.time_ns = time_;
    header.answers = gate_.last_sequence();
    header.count = static_cast<std::uint16_t>(sensors_.size());
    header.state = state;
    std::size_t const size = rr_write(&header, sensors_.data(), frame_.data(), frame_.size());
    port_.send(std::span<unsigned char const>(frame_).first(size), gate_.peer());
  }

  void send_description(std::uint32_t part, Peer to) {
    auto const parts = (description_.size() + RR_PART_SIZE - 1) / RR_PART_SIZE;
    if (part >= parts) return;
    std::size_t const from = part * RR_PART_SIZE;
    std::size_t const size = std::min<std::size_t>(RR_PART_SIZE, description_.size() - from);
    send_part({description_.data() + from, size}, part, static_cast<std::uint32_t>(parts), to);
    asked_ = part + 1 == parts;
  }

  void send_part(std::span<char const> text, std::uint32_t part, std::uint32_t parts, Peer to) {
    rr_header header{};
    header.kind = RR_DESCRIPTION;
    header.session = static_cast<std::uint32_t>(settings_.session);
    header.sequence = part;
    header.answers = parts;
    header.count = static_cast<std::uint16_t>(text.size());
    std::copy(text.begin(), text.end(), frame_.begin() + RR_HEADER_SIZE);
    std::size_t const size = rr_seal(&header, frame_.data(), text.size());
    port_.send(std::span<unsigned char const>(frame_).first(size), to);
  }

  Plant& plant_;
  Port& port_;
  Clock& clock_;
  ServerSettings settings_;
  std::int64_t period_, give_up_;  ///< [ns]
  CommandGate gate_;
  Watchdog watchdog_;
  std::string description_;
  std::vector<double> sensors_;
  Record record_{};
  Statistics statistics_{};
  std::array<unsigned char, RR_LARGEST_FRAME + 1> buffer_{},
      frame_{};  ///< one more: a longer datagram is seen to be longer
  std::atomic<bool> stop_{false};
  std::uint32_t sequence_{0};
  std::int64_t time_{0};  ///< simulated [ns]
  bool fresh_{false};     ///< a command that has not acted yet
  bool asked_{false};     ///< the last part of the description has just been sent: its reader has no sensors yet
};

}  // namespace rollerrig::realtime
