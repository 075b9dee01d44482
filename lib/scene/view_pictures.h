// The four views as models see them: over white, alone or together on one labelled sheet.
#ifndef PHYSMAS_SCENE_VIEW_PICTURES_H
#define PHYSMAS_SCENE_VIEW_PICTURES_H

#include <string>
#include <vector>

#include "records/scene.h"
#include "scene/image.h"

namespace physmas {

// A view's picture over white, RGB.
struct ViewPicture {
  std::string view;
  Image rgb;
};

// Loads the scene's views. Errors (exit code 3) as load_image, and when an image has not its camera's size.
std::vector<ViewPicture> load_view_pictures(const Scene& scene);

// The pictures in a grid of two columns, each with its view's name below; those of another size than the first are
// scaled to it.
Image view_sheet(const std::vector<ViewPicture>& views);

}  // namespace physmas

#endif
