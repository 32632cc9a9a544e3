// Frames of the server: what the C header writes it reads, and nothing else passes the gate.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "realtime/rig.hpp"

using namespace rollerrig::realtime;
using namespace rollerrig::test;

namespace {

struct AskedGate : CommandGate {
  AskedGate() : CommandGate(two_inputs(), session, 3) { REQUIRE(judge(asking(), us, 1) == Verdict::asked); }
};

}  // namespace

TEST_CASE("CRC is that of zlib: the check number of the standard") { CHECK(rr_crc32("123456789", 9) == 0xcbf43926u); }

TEST_CASE("a frame is little-endian at the documented offsets") {
  Frame const frame = command(0x01020304u, 0x0a0b0c0du, {1.0, 2.0}, RR_REARM);
  REQUIRE(frame.size() == 52);
  CHECK(frame[0] == 'R');
  CHECK(frame[3] == 'G');
  CHECK(frame[4] == 1);
  CHECK(frame[5] == RR_COMMAND);
  CHECK(frame[6] == 1);
  CHECK(frame[8] == session);
  CHECK(frame[12] == 4);
  CHECK(frame[15] == 1);
  CHECK(frame[24] == 0x0d);
  CHECK(frame[28] == 2);
  CHECK(frame[38] == 0xf0);  // 1.0 = 3ff0000000000000
  CHECK(frame[39] == 0x3f);
}

TEST_CASE("what is written is read, and a buffer too small is refused") {
  Heard const h = heard(command(9, 4, {-0.0, 1e-300}));
  CHECK(h.header.sequence == 9);
  CHECK(h.header.answers == 4);
  CHECK(std::signbit(h.values[0]));
  CHECK(h.values[1] == 1e-300);
  rr_header header{};
  header.count = 2;
  double const values[2] = {};
  unsigned char small[51];
  CHECK(rr_write(&header, values, small, sizeof small) == 0);
}

TEST_CASE("each kind of bad frame is dropped under its own name") {
  AskedGate gate;
  std::uint32_t const sent = 10;
  Frame const good = command(5, 10, {1.0, 2.0});
  auto const changed = [&](std::size_t at, unsigned char to) {
    Frame frame = good;
    frame[at] = to;
    return frame;
  };
  CHECK(gate.judge(Frame(good.begin(), good.begin() + 20), us, sent) == Verdict::wrong_length);
  CHECK(gate.judge({}, us, sent) == Verdict::wrong_length);
  CHECK(gate.judge(changed(0, 'X'), us, sent) == Verdict::foreign);
  CHECK(gate.judge(changed(4, 2), us, sent) == Verdict::other_version);
  CHECK(gate.judge(changed(40, 1), us, sent) == Verdict::corrupt);
  CHECK(gate.judge(good, somebody, sent) == Verdict::foreign);
  CHECK(gate.judge(command(5, 10, {1.0, 2.0}, 0, session + 1), us, sent) == Verdict::foreign);
  CHECK(gate.judge(command(5, 10, {1.0}), us, sent) == Verdict::wrong_length);
  CHECK(gate.judge(command(5, 11, {1.0, 2.0}), us, sent) == Verdict::not_allowed);  // answers what was not sent
  CHECK(gate.judge(command(5, 6, {1.0, 2.0}), us, sent) == Verdict::late);
  CHECK(gate.judge(command(5, 10, {1.0, 1.5}), us, sent) == Verdict::not_allowed);
  CHECK(gate.judge(command(5, 10, {11.0, 1.0}), us, sent) == Verdict::not_allowed);
  for (double const bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    CHECK(gate.judge(command(5, 10, {bad, 1.0}), us, sent) == Verdict::not_allowed);
  CHECK(gate.counted(Verdict::accepted) == 0);

  CHECK(gate.judge(good, us, sent) == Verdict::accepted);
  CHECK(gate.command()[1] == 2.0);
  CHECK(gate.judge(good, us, sent) == Verdict::repeated);
  CHECK(gate.judge(command(4, 10, {3.0, 2.0}), us, sent) == Verdict::reordered);
  CHECK(gate.command()[0] == 1.0);
  CHECK(gate.judge(command(8, 7, {3.0, 2.0}), us, sent) ==
        Verdict::accepted);  // numbers may be left out, 3 periods are no delay
}

TEST_CASE("sequences go round") {
  AskedGate gate;
  CHECK(gate.judge(command(0xffffffffu, 0xffffffffu, {0.0, 0.0}), us, 0) == Verdict::accepted);
  CHECK(gate.judge(command(0, 0, {0.0, 0.0}), us, 0) == Verdict::accepted);
  CHECK(gate.judge(command(0xffffffffu, 0, {0.0, 0.0}), us, 0) == Verdict::reordered);
}

TEST_CASE("one controller at a time; the next one when the first has been given up") {
  AskedGate gate;
  CHECK(gate.judge(asking(), somebody, 1) == Verdict::refused);
  CHECK(gate.judge(command(1, 1, {0.0, 0.0}), us, 1) == Verdict::accepted);
  gate.give_up_peer();
  CHECK(gate.judge(asking(), somebody, 1) == Verdict::asked);
  CHECK(gate.judge(command(1, 1, {0.0, 0.0}), somebody, 1) == Verdict::accepted);  // counts anew
  CHECK(gate.judge(command(2, 1, {0.0, 0.0}), us, 1) == Verdict::foreign);
}

TEST_CASE("a million frames of noise: none is acted on, none does harm") {
  AskedGate gate;
  std::mt19937 random(1);
  std::uint64_t accepted = 0, dropped = 0;
  std::uint32_t sequence = 0;
  unsigned char buffer[RR_LARGEST_FRAME];
  for (int i = 0; i < 1'000'000; ++i) {
    ++sequence;
    Frame frame = command(sequence, sequence, {1.0, 2.0});
    unsigned const what = random() % 8;
    if (what == 0) {  // bytes from nowhere, of any length
      frame.resize(random() % 80);
      for (auto& byte : frame) byte = static_cast<unsigned char>(random());
    } else if (what == 1) {
      frame.resize(random() % frame.size());
    } else if (what == 2) {
      frame.resize(frame.size() + 1 + random() % 30);
    } else if (what < 7) {  // up to four bytes changed
      for (unsigned n = what - 2; n > 0; --n)
        frame[random() % frame.size()] ^= static_cast<unsigned char>(1 + random() % 255);
      if (frame == command(sequence, sequence, {1.0, 2.0})) frame[0] ^= 1;
    } else {  // fields changed under a good CRC
      std::size_t const at = 4 + random() % 44;
      frame[at] ^= static_cast<unsigned char>(1 + random() % 255);
      rr_put(frame.data() + 48, rr_crc32(frame.data(), 48), 4);
    }
    std::copy(frame.begin(), frame.end(), buffer);
    Verdict const verdict = gate.judge(std::span<unsigned char const>(buffer, frame.size()), us, sequence);
    if (verdict != Verdict::accepted) {
      ++dropped;
      continue;
    }
    ++accepted;  // only a whole frame with allowed values, whatever else its sender wrote
    REQUIRE(what == 7);
    REQUIRE(std::abs(gate.command()[0]) <= 10.0);
    REQUIRE((gate.command()[1] == 0.0 || gate.command()[1] == 1.0 || gate.command()[1] == 2.0));
    sequence = gate.last_sequence();
  }
  std::uint64_t counted = 0;
  for (std::size_t v = 0; v < verdict_count; ++v) counted += gate.counted(static_cast<Verdict>(v));
  CHECK(counted == 1'000'001);
  CHECK(accepted + dropped == 1'000'000);
  for (Verdict const v : {Verdict::wrong_length, Verdict::foreign, Verdict::other_version, Verdict::corrupt,
                          Verdict::late, Verdict::reordered, Verdict::not_allowed})
    CHECK(gate.counted(v) > 0);
}
