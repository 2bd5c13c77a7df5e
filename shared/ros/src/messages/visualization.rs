//! `visualization_msgs`.

use serde::{Deserialize, Serialize};

use super::geometry::{Point, Pose, Vector3};
use super::sensor::CompressedImage;
use super::standard::{ColorRgba, Duration, Header, Text};
use crate::cdr::RosMessage;

/// A coordinate in a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UvCoordinate {
    /// To the right.
    pub u: f32,
    /// Up.
    pub v: f32,
}

/// A mesh; here always an empty one.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Its name.
    pub filename: Text,
    /// The mesh.
    pub data: Vec<u8>,
}

/// Something to draw.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Time and frame.
    pub header: Header,
    /// Name of a group of markers.
    pub ns: Text,
    /// Number within the group.
    pub id: i32,
    /// Shape; see the definition.
    #[serde(rename = "type")]
    pub shape: i32,
    /// 0: add, 2: delete.
    pub action: i32,
    /// Pose of the shape.
    pub pose: Pose,
    /// Size, m; x of a list of lines is their width.
    pub scale: Vector3,
    /// Colour.
    pub color: ColorRgba,
    /// Time until it is deleted; 0: never.
    pub lifetime: Duration,
    /// Moves with its frame.
    pub frame_locked: bool,
    /// Points of a list, relative to the pose.
    pub points: Vec<Point>,
    /// A colour for each point; may be empty.
    pub colors: Vec<ColorRgba>,
    /// Name of a texture.
    pub texture_resource: Text,
    /// A texture.
    pub texture: CompressedImage,
    /// Where each point is in the texture.
    pub uv_coordinates: Vec<UvCoordinate>,
    /// A text to show.
    pub text: Text,
    /// Name of a mesh.
    pub mesh_resource: Text,
    /// A mesh.
    pub mesh_file: MeshFile,
    /// Whether the mesh has its own materials.
    pub mesh_use_embedded_materials: bool,
}

/// Several markers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// The markers.
    pub markers: Vec<Marker>,
}

impl RosMessage for MarkerArray {
    const NAME: &'static str = "visualization_msgs/msg/MarkerArray";
}
