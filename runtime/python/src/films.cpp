// Films of runs, and the page that plays them, in a notebook or a browser.

#include <atoll/playback.h>
#include <atoll/recording.h>
#include <atoll/scene.h>
#include <atoll/shapes.h>
#include <atoll/world.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <variant>

#include "fields.h"
#include "parts.h"
#include "signals.h"
#include "view/colour.h"
#include "view/film.h"
#include "view/film_page.h"
#include "view/triangles.h"

namespace atl::python {
namespace {

// Notebooks keep what they show in their file, and some show no more than this. 600 frames of 5000 boxes take 12 MB.
constexpr std::size_t max_notebook_bytes = 16 << 20;  // bytes
constexpr int default_height = 620;                   // pixels

// The film of a world, which another thread may step at the same time.
struct Roll {
  explicit Roll(view::FilmOptions options) : film(std::move(options)) {}

  std::mutex lock;
  view::Film film;
  bool rolling = true;
};

view::FilmOptions options_of(const char* call, std::string name, int every, std::string show) {
  if (every < 1) {
    throw Error(std::string(call) + ": every is " + std::to_string(every) + "; expected 1 step a frame, or more");
  }
  return {.name = std::move(name), .place = std::move(show), .stride = every};
}

class Film {
 public:
  explicit Film(view::FilmOptions options) : roll_(std::make_shared<Roll>(std::move(options))) {}

  /// Follows the world's steps from here on, as long as there is this film and it wasn't ended.
  void follow(World& world) {
    world.add_step_observer([roll = std::weak_ptr(roll_)](const World& of, const StepReport& report, double dt) {
      const std::shared_ptr<Roll> kept = roll.lock();
      if (!kept) return false;
      const std::lock_guard held(kept->lock);
      if (kept->rolling) kept->film.add(of, report, dt);
      return kept->rolling;
    });
    roll_->film.begin(world);
  }
  view::Film& film() { return roll_->film; }  // that nobody else knows yet

  void end() {
    const std::lock_guard held(roll_->lock);
    roll_->rolling = false;
  }
  bool rolling() const {
    const std::lock_guard held(roll_->lock);
    return roll_->rolling;
  }
  std::size_t frames() const {
    const std::lock_guard held(roll_->lock);
    return roll_->film.frames();
  }
  std::size_t bodies() const {
    const std::lock_guard held(roll_->lock);
    return roll_->film.bodies().size();
  }

  /// Ends it, since a film's text is its end. Made once.
  const std::string& page() {
    const std::lock_guard held(roll_->lock);
    if (!page_.empty()) return page_;
    if (!view::has_page()) throw Error(without_page);
    roll_->rolling = false;
    std::ostringstream out;
    write_page(out, roll_->film);
    return page_ = std::move(out).str();
  }
  std::string framed(int height) {
    if (height < 1) throw Error("Film.html: height is " + std::to_string(height) + "; expected pixels, 1 or more");
    return view::framed(page(), height);
  }
  std::string shown() {
    if (!view::has_page()) return "<p>" + std::string(without_page) + "</p>";
    std::string element = framed(default_height);
    if (element.size() <= max_notebook_bytes) return element;
    std::ostringstream words;
    words.precision(3);
    words << "<p>A film of " << frames() << " frames and " << bodies() << " bodies, which takes "
          << static_cast<double>(element.size()) / (1 << 20) << " MB: more than the " << (max_notebook_bytes >> 20)
          << " MB that are put into a notebook. <code>save(path)</code> writes its page, <code>open()</code> shows it, "
             "and "
             "<code>every=</code> makes films of fewer frames.</p>";
    return words.str();
  }
  void save(const std::string& path) {
    const std::string& text = page();
    std::ofstream out(path, std::ios::binary);
    if (!out.write(text.data(), static_cast<std::streamsize>(text.size())).flush()) {
      throw Error("Film.save: can't write " + path + "; expected a file that can be written");
    }
  }

 private:
  static constexpr const char* without_page =
      "This build of atoll has no page that plays runs: npm was not found when it was built, which bundles the page";

  std::shared_ptr<Roll> roll_;
  std::string page_;
};

Film film_of(World& world, int every, std::string name, std::string show) {
  Film film(options_of("World.film", std::move(name), every, std::move(show)));
  film.follow(world);
  return film;
}

Film view_of(const World& world, std::string name, std::string show) {
  Film film(options_of("World.view", std::move(name), 1, std::move(show)));
  film.film().begin(world);
  film.end();
  return film;
}

struct ViewOptions {
  int every;
  std::int64_t first;
  std::optional<std::int64_t> last;
  std::string show;
  int threads;
  Simd simd;
};

[[noreturn]] void fail_step(const char* name, std::int64_t found, std::int64_t min, std::int64_t max) {
  throw Error("view: " + std::string(name) + " is " + std::to_string(found) + "; expected " + std::to_string(min) +
              " to " + std::to_string(max) + ", steps of the recording");
}

Film film_of_recording(const std::string& path, const ViewOptions& asked) {
  Playback playback(path, {.threads = asked.threads, .simd = asked.simd, .key_frame_bytes = 0});
  const std::int64_t last = asked.last.value_or(playback.steps());
  if (last < 0 || last > playback.steps()) fail_step("last", last, 0, playback.steps());
  if (asked.first < 0 || asked.first > last) fail_step("first", asked.first, 0, last);
  view::FilmOptions options =
      options_of("view", std::filesystem::path(path).filename().string(), asked.every, asked.show);
  options.first_step = asked.first;
  Film film(std::move(options));
  SignalCheck check_signals;
  playback.seek(asked.first);
  view::watch(playback, last, {&film.film()}, [&] { return check_signals(), true; });
  film.end();
  return film;
}

Film film_of_scene(const Scene& scene, const ViewOptions& asked) {
  if (asked.first != 0 || asked.last) {
    throw Error("view: found first or last of a scene; expected them of a recording (a scene has Scene.steps)");
  }
  Settings settings = scene.settings;
  if (asked.simd != Simd::Auto) settings.simd = asked.simd;
  World world({.gravity = scene.gravity, .threads = asked.threads, .settings = settings});
  const std::vector<BodyId> bodies = build_scene(scene, world);
  Film film(options_of("view", scene.name, asked.every, asked.show));
  film.follow(world);
  SignalCheck check_signals;
  for (int step = 0; step < scene.steps; ++step) {
    apply_forces(scene, world, bodies);
    world.step(scene.dt);
    check_signals();
  }
  film.end();
  return film;
}

Film film_of_source(const std::variant<Scene, std::string>& source, const ViewOptions& asked) {
  if (const auto* scene = std::get_if<Scene>(&source)) return film_of_scene(*scene, asked);
  const std::string& text = std::get<std::string>(source);
  return is_recording(text) ? film_of_recording(text, asked) : film_of_scene(load_scene(text), asked);
}

// In a browser, where there is one. A file that stays, as nobody knows when it was read.
std::string open(Film& film) {
  const nb::object directory = nb::module_::import_("tempfile").attr("mkdtemp")(nb::arg("prefix") = "atoll-");
  const std::string path = nb::cast<std::string>(directory) + "/film.html";
  film.save(path);
  const nb::object address = nb::module_::import_("pathlib").attr("Path")(path).attr("as_uri")();
  nb::module_::import_("webbrowser").attr("open")(address);
  return path;
}

constexpr auto without_gil = nb::call_guard<nb::gil_scoped_release>();

void bind_film(nb::module_& module) {
  nb::class_<Film>(
      module, "Film",
      "What a run looks like, frame by frame. A notebook shows the page that plays it, which holds all it "
      "needs; save() and open() are for elsewhere. `with world.film() as film:` films what is in the block.")
      .def_prop_ro("frames", &Film::frames, "so far; the first is ahead of all steps")
      .def_prop_ro("bodies", &Film::bodies, "how many were seen so far")
      .def_prop_ro("rolling", &Film::rolling, "whether steps of its world still come to it")
      .def("end", &Film::end, "Takes no more frames. What asks for its page ends it, too.")
      .def("page", &Film::page, without_gil,
           "The page, as HTML. Raises Error where the package was built without it: see has_page().")
      .def("html", &Film::framed, nb::arg("height") = default_height, without_gil,
           "The page as an element to put into another one, so many pixels high and as wide as there is room.")
      .def("_repr_html_", &Film::shown, without_gil)
      .def("save", &Film::save, nb::arg("path"), without_gil, "Writes the page to a file.")
      .def("open", &open, "Writes the page to a file of its own, shows it in a browser, and tells where it is.")
      .def(
          "__enter__", [](nb::object self) { return self; }, nb::sig("def __enter__(self) -> Film"))
      .def(
          "__exit__", [](Film& self, nb::args) { self.end(); }, nb::sig("def __exit__(self, *reason: object) -> None"))
      .def("__repr__", [](const Film& self) {
        return "<Film of " + std::to_string(self.frames()) + " frames, " + std::to_string(self.bodies()) + " bodies" +
               (self.rolling() ? ", rolling>" : ">");
      });
}

}  // namespace

void bind_films(nb::module_& module) {
  bind_film(module);
  nb::borrow<nb::class_<World>>(module.attr("World"))
      .def("film", &film_of, nb::kw_only(), nb::arg("every") = 1, nb::arg("name") = "world", nb::arg("show") = "",
           "Films this world from here on: a frame now, and one after every so many steps, whoever asks for these, "
           "until the film is ended or shown. name: the page's title. show: what the page shows first, as "
           "\"body=7&colour=force&contacts&joints&boxes&play\". No bit of what the world does depends on it.")
      .def("view", &view_of, nb::kw_only(), nb::arg("name") = "world", nb::arg("show") = "",
           "This world as it stands, as a film of one frame.");
  module.def(
      "triangles_of",
      [](const Shape& shape) {
        constexpr int around = 48;  // so many flat sides look round
        const view::Triangles all = view::triangles_of(shape, around);
        const double* vertices = all.vertices.empty() ? nullptr : all.vertices.front().data();
        const std::uint32_t* triangles = all.triangles.empty() ? nullptr : all.triangles.front().data();
        return nb::make_tuple(nb::steal(array_of(vertices, {all.vertices.size(), 3})),
                              nb::steal(array_of(triangles, {all.triangles.size(), 3})));
      },
      nb::arg("shape"),
      nb::sig("def triangles_of(shape: object) -> tuple[numpy.typing.NDArray[numpy.float64], "
              "numpy.typing.NDArray[numpy.uint32]]"));
  module.def(
      "colour_of",
      [](std::size_t number, bool moves) {
        const view::Colour colour = moves ? view::body_colour(number) : view::static_colour;
        return std::tuple(colour.r, colour.g, colour.b);
      },
      nb::arg("number"), nb::arg("moves"));
  module.def("has_page", &view::has_page,
             "Whether the page that plays films was built into the package: where npm was when it was built.");
  module.def(
      "view",
      [](const std::variant<Scene, std::string>& source, int every, std::int64_t first,
         std::optional<std::int64_t> last, std::string show, int threads, Simd simd) {
        return film_of_source(source, {every, first, last, std::move(show), threads, simd});
      },
      nb::arg("source"), nb::kw_only(), nb::arg("every") = 1, nb::arg("first") = 0, nb::arg("last") = nb::none(),
      nb::arg("show") = "", nb::arg("threads") = 1, nb::arg("simd") = Simd::Auto, without_gil,
      "Films a recording, by its path, from after step `first` to after step `last`; or a scene, a Scene or as "
      "load_scene() takes it, which is run for its steps. A frame every so many steps. Raises Error and SceneError.");
}

}  // namespace atl::python
