// Runs a target without libFuzzer: on the inputs of a folder, and on so many that are made of these at random, the same
// on every machine, in the target's own way where it has one. It looks for no new paths; it is here to see what is
// known, and in every build.

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "target.h"

// Null where the target has none.
extern "C" __attribute__((weak)) std::size_t LLVMFuzzerCustomMutator(std::uint8_t*, std::size_t, std::size_t,
                                                                     unsigned int);

namespace {

namespace fs = std::filesystem;
using Input = std::vector<std::uint8_t>;

std::vector<Input> read_folder(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<Input> inputs;
  for (const fs::path& path : paths) {
    std::ifstream stream(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return inputs;
}

void mutate(Input& input, const std::vector<Input>& all, std::mt19937& random) {
  const auto place = [&](std::size_t size) { return size == 0 ? 0 : random() % size; };
  for (unsigned left = 1 + random() % 6; left > 0; --left) {
    const std::size_t at = place(input.size());
    switch (random() % 7) {
      case 0:
        if (!input.empty()) input[at] ^= static_cast<std::uint8_t>(1u << random() % 8);
        break;
      case 1:
        if (!input.empty()) input[at] = static_cast<std::uint8_t>(random());
        break;
      case 2:
        if (!input.empty()) input[at] = random() % 2 != 0 ? 0xff : 0;
        break;
      case 3:
        input.insert(input.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(random()));
        break;
      case 4: {
        const std::size_t count = std::min<std::size_t>(input.size() - at, 1 + random() % 16);
        const auto begin = input.begin() + static_cast<std::ptrdiff_t>(at);
        input.erase(begin, begin + static_cast<std::ptrdiff_t>(count));
        break;
      }
      case 5: {  // a piece of another
        const Input& other = all[random() % all.size()];
        const std::size_t from = place(other.size());
        const std::size_t count = std::min({other.size() - from, input.size() - at, std::size_t{64}});
        std::copy_n(other.begin() + static_cast<std::ptrdiff_t>(from), count,
                    input.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      }
      default:
        if (random() % 4 == 0) input.resize(at);
    }
  }
}

// In the target's own way every other time.
void change(Input& input, const std::vector<Input>& all, std::mt19937& random) {
  if (LLVMFuzzerCustomMutator == nullptr || random() % 2 == 0) return mutate(input, all, random);
  const std::size_t size = input.size(), max = size + 256;
  input.resize(max);
  input.resize(LLVMFuzzerCustomMutator(input.data(), size, max, random()));
}

void run(const Input& input) { LLVMFuzzerTestOneInput(input.data(), input.size()); }

}  // namespace

// Mutates one input, without pieces of others.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size) {
  static std::mt19937 random(2);
  Input input(data, data + size);
  mutate(input, {input}, random);
  input.resize(std::min(input.size(), max_size));
  std::copy(input.begin(), input.end(), data);
  return input.size();
}

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: " << argv[0] << " FOLDER RUNS\n";
    return 2;
  }
  const std::vector<Input> inputs = read_folder(argv[1]);
  if (inputs.empty()) {
    std::cerr << argv[1] << " has no inputs\n";
    return 2;
  }
  const auto runs = std::strtoul(argv[2], nullptr, 10);
  std::mt19937 random(1);
  Input input;
  try {
    for (const Input& each : inputs) run(input = each);
    for (unsigned long i = 0; i < runs; ++i) {
      input = inputs[random() % inputs.size()];
      change(input, inputs, random);
      run(input);
    }
  } catch (const std::exception& error) {
    std::ofstream("finding", std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
    std::cerr << "found, with the input in ./finding: " << error.what() << '\n';
    return 1;
  }
  std::cout << inputs.size() << " inputs and " << runs << " made of them\n";
}
