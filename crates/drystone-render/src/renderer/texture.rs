//! Images on the device, with mip levels.

use drystone_scene::visual::Image;

/// Uploads an image; `srgb` says whether its values are colors.
pub(super) fn load(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    image: &Image,
    srgb: bool,
) -> wgpu::TextureView {
    let most = device.limits().max_texture_dimension_2d;
    let mut levels = vec![image.clone()];
    while let Some(last) = levels.last().filter(|last| last.width > 1 || last.height > 1) {
        levels.push(halved(last, srgb));
    }
    levels.retain(|level| level.width.max(level.height) <= most);
    let Some(first) = levels.first() else { return load(device, queue, &white(), srgb) };
    let format =
        if srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm };
    let size = |image: &Image| wgpu::Extent3d {
        width: image.width,
        height: image.height,
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("image"),
        size: size(first),
        mip_level_count: u32::try_from(levels.len()).unwrap_or(1),
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, level) in (0_u32..).zip(&levels) {
        let to = wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * level.width),
            rows_per_image: None,
        };
        queue.write_texture(to, &level.rgba, layout, size(level));
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// One white pixel.
pub(super) fn white() -> Image {
    Image { width: 1, height: 1, rgba: vec![255; 4] }
}

/// The image at half size, rounded down. Each pixel is the mean of four; colors are averaged as
/// linear light.
fn halved(image: &Image, srgb: bool) -> Image {
    let light = light_of_bytes();
    image.halved(|channel, bytes| {
        let mean = if srgb && channel < 3 {
            let mean = bytes.iter().map(|b| light[usize::from(*b)]).sum::<f32>() / 4.0;
            let above = light.partition_point(|l| *l < mean).min(255);
            let below = above.saturating_sub(1);
            let nearer = mean - light[below] < light[above] - mean;
            if nearer { below } else { above }
        } else {
            (bytes.iter().map(|b| usize::from(*b)).sum::<usize>() + 2) / 4
        };
        u8::try_from(mean).unwrap_or(u8::MAX)
    })
}

/// The linear light of each byte of an sRGB color, 0 to 1.
fn light_of_bytes() -> [f32; 256] {
    std::array::from_fn(|byte| {
        #[expect(clippy::cast_precision_loss, reason = "at most 255")]
        let c = byte as f32 / 255.0;
        if c <= 0.04045 {
            return c / 12.92;
        }
        // x^2.4 = x² · y² with y⁵ = x, by Newton's method.
        let x = (c + 0.055) / 1.055;
        let y = (0..16).fold(1.0_f32, |y, _| (4.0 * y + x / (y * y * y * y)) / 5.0);
        x * x * y * y
    })
}

#[cfg(test)]
mod tests {
    use super::{Image, halved, light_of_bytes};

    #[test]
    fn bytes_of_colors_stand_for_light() {
        let light = light_of_bytes();
        // Values from IEC 61966-2-1: 188 is half of the light.
        for (byte, expected) in [(0, 0.0), (10, 0.003_035), (188, 0.502_886), (255, 1.0)] {
            assert!((light[byte] - expected).abs() < 1.0e-5, "{byte}: {}", light[byte]);
        }
    }

    #[test]
    fn a_board_of_black_and_white_is_half_as_bright_from_afar() {
        let point = |white: bool| if white { [255; 4] } else { [0, 0, 0, 255] };
        let rgba: Vec<u8> = (0..16).flat_map(|i| point((i + i / 4) % 2 == 0)).collect();
        let image = Image { width: 4, height: 4, rgba };
        let small = halved(&image, true);
        assert_eq!((small.width, small.height, small.rgba.len()), (2, 2, 16));
        assert!(small.rgba.chunks(4).all(|p| p == [188, 188, 188, 255]), "{:?}", small.rgba);
        assert!(halved(&image, false).rgba.chunks(4).all(|p| p == [128, 128, 128, 255]));
    }
}
