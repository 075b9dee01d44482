// pm-scene: makes scene bundles, and cuts their run specification into slices.
#include "base/command_line.h"
#include "bundle/import_bundle.h"
#include "bundle/report.h"
#include "bundle/synth_bundle.h"
#include "plan/prompt.h"
#include "records/json.h"
#include "records/overrides.h"
#include "records/scene.h"
#include "records/slices.h"

using namespace physmas;

namespace {
constexpr double kDropByPrompt = -1;

// `--crop auto` has one word where `--crop` has six numbers, which the parser cannot tell: it becomes an option of its
// own. Returns how many words are left.
int take_crop_auto(int argc, char** argv, bool& crop_auto) {
  int kept = 0;
  for (int i = 0; i < argc; ++i) {
    const std::string word = argv[i], next = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--") {
      while (i < argc) argv[kept++] = argv[i++];
      break;
    }
    if (word == "--crop=auto" || (word == "--crop" && next == "auto")) {
      crop_auto = true;
      i += word == "--crop";
    } else {
      argv[kept++] = argv[i];
    }
  }
  return kept;
}

}  // namespace

int main(int argc, char** argv) {
  std::string example, scene, described, folder, overrides_file, prompt;
  std::vector<std::string> settings, defaults;
  std::vector<double> crop;
  std::vector<std::string> reading;
  bundle::ImportOptions import;
  bool true_masks = false;
  Command synth_command, import_command, slice_command, info_command;

  ToolMain tool;
  tool.name = "pm-scene";
  tool.description = "Makes scene bundles: from primitives (synth) or from a file of 3D Gaussians (import).";
  tool.footer =
      "Examples: pm-scene synth examples/cake.json --out runs/cake/scene\n"
      "          pm-scene import guitar.compressed.ply --up=-y --prompt \"the guitar falls onto the floor\" --out DIR\n"
      "Reads:    example.json, .ply, .compressed.ply, .spz, .sog, .splat    Writes: scene.json, gaussians.ply, "
      "views/*.png";
  tool.options = [&](Command app) {
    app.require_subcommand(1);
    app.fallthrough();
    synth_command = app.add_subcommand("synth", "A bundle from a scene described by primitives");
    synth_command.add_option("EXAMPLE", example, "The description (docs/scenes.md)").required();
    synth_command.add_option("--out", folder, "Folder of the bundle").required();
    synth_command.add_flag("--true-masks", true_masks, "Also write the true masks, true-masks/VIEW/OBJECT/PART.png");

    import_command = app.add_subcommand("import", "A bundle from a file of 3D Gaussians");
    import_command
        .add_option("FILE", import.gaussians,
                    "3DGS .ply, SuperSplat .compressed.ply, .spz, .sog or the folder of one, .splat; also within gzip")
        .required();
    import_command.add_option("--prompt", import.prompt, "What shall happen").required();
    import_command.add_option("--out", folder, "Folder of the bundle").required();
    import_command
        .add_option("--up", import.up,
                    "Scene axis that points up; when absent z in nerfstudio's frame, else what FILE says, else -y")
        .one_of({"x", "y", "z", "-x", "-y", "-z"});
    import_command.add_option("--front", import.front,
                              "Axis that the front of things faces, degrees about up from the usual front towards the "
                              "right, or the view of --cameras that is the front");
    import_command
        .add_option("--opacity-threshold", import.selection.opacity_threshold,
                    "Take Gaussians of a higher opacity only")
        .between(0.0, 1.0);
    import_command
        .add_option(
            "--crop", crop,
            "Take Gaussians inside x0 x1 y0 y1 z0 z1 only, in the file's units; auto: the object, the largest dense "
            "component")
        .expected(6);
    import_command
        .add_option("--read", reading,
                    "linear-scales: scales are no logarithms; drop-broken: leave out Gaussians that no renderer draws, "
                    "however many")
        .one_of({"linear-scales", "drop-broken"})
        .take_all();
    Option views = import_command.add_option("--views", import.views, "Folder with images of your own");
    import_command
        .add_option("--cameras", import.cameras,
                    "Their cameras: JSON list of four {name, image, camera}, transforms.json, 3DGS cameras.json, or "
                    "a COLMAP model's folder")
        .needs(views);
    views.needs("--cameras");
    import_command
        .add_option("--dataparser-transforms", import.dataparser,
                    "nerfstudio's dataparser_transforms.json for --cameras, or none; the one beside FILE or the "
                    "cameras when absent")
        .needs("--cameras");
    import_command.add_option("--inventory", import.inventory, "Authored inventory");
    import_command.add_option("--masks", import.masks, "Authored masks: VIEW/OBJECT.png, VIEW/OBJECT/PART.png");
    import_command.add_option("--run", import.run, "Run specification; what it leaves out has its default");
    import_command.add_option("--physgaussian", import.physgaussian,
                              "PhysGaussian configuration to take the run specification from");
    import_command
        .add_option("--materials", import.material_field,
                    "Material field of another program: .npz with positions, youngs_modulus, poisson_ratio "
                    "and density, or .usda with points, yms, prs and rhos")
        .type_name("FILE");
    import_command.add_option("--name", import.name, "Id of the scene [a-z0-9-]; made from FILE when absent");
    import.drop = kDropByPrompt;
    import_command
        .add_option(
            "--drop", import.drop,
            "Height above the floor that is added, solver units; by default 0.15 where the prompt begins with a "
            "fall, else 0")
        .between(0.0, 1.0);
    const auto add_angle = [&](const char* flag, double& value, double limit, const char* text) {
      import_command.add_option(flag, value, text).between(-limit, limit).capture_default_str();
    };
    add_angle("--view-elevation", import.view_elevation, 80, "Of the four views that are rendered, degrees");
    add_angle("--azimuth", import.azimuth, 360, "Of the output camera, degrees from the front to the right");
    add_angle("--elevation", import.elevation, 80, "Of the output camera, degrees");

    slice_command =
        app.add_subcommand("slice", "One slice of scene.json per stage, each rewritten only when it changes");
    slice_command.add_option("--scene", scene, "scene.json").required();
    slice_command.add_option("--set", settings, "Run setting KEY=VALUE, such as screening.tau=0.6")
        .expected(1)
        .take_all();
    slice_command.add_option("--default", defaults, "Run setting KEY=VALUE where the scene says nothing of it")
        .expected(1)
        .take_all();
    slice_command.add_option("--overrides", overrides_file, "Run specification whose fields win over the scene's");
    slice_command.add_option("--prompt", prompt, "What shall happen, instead of what the scene says");
    slice_command.add_option("--out", folder, "Folder of the slices").required();

    info_command = app.add_subcommand("info", "What a file of Gaussians or a scene.json holds");
    info_command.add_option("FILE", described, "A file of Gaussians, or scene.json").required();
  };
  tool.work = [&](const CommonOptions&) {
    import.folder = folder;
    if (!crop.empty()) import.selection.crop = bundle::crop_box(crop, "--crop");
    for (const std::string& word : reading) {
      import.reading.linear_scales |= word == "linear-scales";
      import.reading.drop_broken |= word == "drop-broken";
    }
    if (synth_command.parsed()) bundle::write_synth_bundle(example, folder, true_masks);
    if (import.drop == kDropByPrompt)
      import.drop = plan::starts_in_the_air(import.prompt) ? bundle::ImportOptions().drop : 0;
    if (import_command.parsed()) bundle::write_import_bundle(import);
    if (slice_command.parsed())
      write_slices(scene, run_overrides(overrides_file, settings), run_overrides("", defaults), prompt, folder);
    if (info_command.parsed()) bundle::print_report(described);
    return 0;
  };
  argc = take_crop_auto(argc, argv, import.selection.crop_dense);
  return run_tool(argc, argv, tool);
}
