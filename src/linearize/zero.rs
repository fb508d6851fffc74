//! stub
/// z
#[derive(Clone, Debug)]
pub struct ZeroMode {}
pub(crate) fn zero_modes(_: &crate::model::Model, _: &super::assemble::Assembly, _: &[crate::precision::Ball]) -> Vec<ZeroMode> { Vec::new() }
