// Rings of frames in shared memory: in order, the newest eight where the reader is slow, and no frame that was torn.
#include <doctest/doctest.h>

#include <memory>
#include <thread>

#include "realtime/rig.hpp"
#include "rollerrig_shm.h"

using namespace rollerrig::test;

namespace {

constexpr std::size_t frame_size = 4132;  ///< the largest: 512 numbers

Frame numbered(std::uint32_t n) {
  Frame frame = command(n, n, std::vector<double>(512, n));
  REQUIRE(frame.size() == frame_size);
  return frame;
}

struct Reader {
  rr_ring& ring;
  std::uint64_t next{0};
  Frame buffer = Frame(5000);

  /// Sequence of the next frame; 0: none.
  std::uint32_t read() {
    long const size = rr_ring_get(&ring, &next, buffer.data(), buffer.size());
    if (size < 0) return 0;
    rr_header header;
    CHECK(rr_open(buffer.data(), static_cast<std::size_t>(size), &header) == RR_OK);
    return header.sequence;
  }
};

}  // namespace

TEST_CASE("frames come in their order, and a slow reader finds the last eight") {
  auto const ring = std::make_unique<rr_ring>();
  Reader reader{*ring};
  CHECK(reader.read() == 0);
  for (std::uint32_t n = 1; n <= 3; ++n) rr_ring_put(ring.get(), numbered(n).data(), frame_size);
  for (std::uint32_t n = 1; n <= 3; ++n) CHECK(reader.read() == n);
  CHECK(reader.read() == 0);
  for (std::uint32_t n = 4; n <= 20; ++n) rr_ring_put(ring.get(), numbered(n).data(), frame_size);
  for (std::uint32_t n = 13; n <= 20; ++n) CHECK(reader.read() == n);
  CHECK(reader.read() == 0);
}

TEST_CASE("a size or a count that cannot be does no harm") {
  auto const ring = std::make_unique<rr_ring>();
  Reader reader{*ring};
  rr_ring_put(ring.get(), numbered(1).data(), frame_size);
  ring->slot[0].size = 0xffffffffu;
  unsigned char small[100];
  CHECK(rr_ring_get(ring.get(), &reader.next, small, sizeof small) == 100);
  ring->written = 1000;  // stamps do not fit
  CHECK(rr_ring_get(ring.get(), &reader.next, small, sizeof small) == -1);
  ring->written = 2;
  CHECK(rr_ring_get(ring.get(), &reader.next, small, sizeof small) == -1);
  CHECK(reader.next == 2);
}

#if !defined(__SANITIZE_THREAD__)
TEST_CASE("a writer and a reader at the same time: what is read is whole") {
  auto const ring = std::make_unique<rr_ring>();
  std::uint32_t constexpr last = 20000;
  std::thread writer([&] {
    for (std::uint32_t n = 1; n <= last; ++n) {
      Frame const frame = command(n, n, std::vector<double>(512, n));
      rr_ring_put(ring.get(), frame.data(), frame.size());
    }
  });
  Reader reader{*ring};
  std::uint32_t before = 0;
  while (before < last)
    if (std::uint32_t const n = reader.read(); n != 0) {
      REQUIRE(n > before);
      before = n;
    }
  writer.join();
  CHECK(before == last);
}
#endif
