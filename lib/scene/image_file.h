// PNG and JPEG files, contact sheets.
#ifndef PHYSMAS_SCENE_IMAGE_FILE_H
#define PHYSMAS_SCENE_IMAGE_FILE_H

#include <cstdint>
#include <string>
#include <vector>

#include "scene/image.h"

namespace physmas {

// The bytes of a PNG of 1, 3 or 4 channels; the same pixels give the same bytes.
std::string encode_png(const Image& image);

// The same for a grey image of 16 bits. levels: [H * W].
std::string encode_png(int width, int height, const std::vector<uint16_t>& levels);

// The bytes of a JPEG of 1 or 3 channels, for pages. quality: 0..100.
std::string encode_jpeg(const Image& image, int quality);

// Writes a PNG of 1, 3 or 4 channels. Atomic; the same pixels give the same bytes. Returns whether the file changed.
// Throws an Error (exit code 3) when the file cannot be written.
bool save_png(const std::string& path, const Image& image);

// Reads an 8-bit PNG or JPEG: grey, RGB or RGBA as stored; 16-bit files are reduced to 8 bits, palettes expanded.
// Throws an Error (exit code 3) naming the file when it is no readable image, or has more than 2^28 pixels or more than
// its bytes can hold.
Image load_image(const std::string& path);
// The same from the file's bytes; `path` is only named in messages.
Image decode_image(const std::string& bytes, const std::string& path);

// The values of a lossless WebP or PNG of 8 bits, as RGBA, whatever of them is stored; one that has no alpha is opaque.
// most: pixels that it may have at all. Errors (exit code 3) name `path`.
Image decode_rgba(const std::string& bytes, const std::string& path, uint64_t most);

// The picture as large as fits into width x height pixels, centred on white; of its channels.
Image fit_into(const Image& picture, int width, int height);

// Writes paragraphs (in ASCII) into the picture's upper left corner, on white that the picture shines through a little;
// they are wrapped at its right edge, and what does not fit into its upper third is left out.
void write_caption(Image& picture, const std::vector<std::string>& paragraphs);

// Pictures side by side in a grid of `columns`, each with its caption (such as the frame number, in ASCII) below it,
// cut where the cell ends; all of the first one's channels. Pictures are scaled down to at most cell_width pixels in
// width and must be of one size.
Image contact_sheet(const std::vector<Image>& pictures, const std::vector<std::string>& captions, int columns,
                    int cell_width);

}  // namespace physmas

#endif
