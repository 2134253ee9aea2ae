/* The order that NumPy's Generator.permutation gives with PCG64 (O'Neill 2014): the same draws, in half the memory.

   A draw above i is rejected by a swap of entry i with itself, which no branch has to predict. */

#include <stdint.h>

typedef unsigned __int128 wide;

void shuffle(const uint64_t *seeded, int32_t *order, int64_t count) {
  const wide factor = (wide)2549297995355413924u << 64 | 4865540595714422341u;
  wide state = (wide)seeded[0] << 64 | seeded[1];
  const wide increment = (wide)seeded[2] << 64 | seeded[3];
  for (int64_t i = 0; i < count; i++) order[i] = i;
  uint32_t mask = 1;
  while (mask < count - 1) mask = 2 * mask + 1;
  for (uint32_t i = count - 1; i > 0;) {
    state = state * factor + increment;
    const uint64_t folded = (uint64_t)(state >> 64) ^ (uint64_t)state;
    const int turns = state >> 122;
    const uint64_t draws = folded >> turns | folded << (-turns & 63);
    for (int half = 0; half < 64 && i > 0; half += 32) {
      const uint32_t draw = (uint32_t)(draws >> half) & mask, accepted = draw <= i, other = i ^ ((draw ^ i) & -accepted);
      const int32_t swapped = order[i];
      order[i] = order[other];
      order[other] = swapped;
      i -= accepted;
      if (i <= mask >> 1) mask >>= 1;
    }
  }
}
