//! No model file and no checkpoint makes its reader panic; a model that is read can be written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taxel_learn::Model;
use taxel_learn::train::Checkpoint;

fuzz_target!(|data: &[u8]| {
    if let Ok(model) = Model::from_bytes(data) {
        let again = Model::from_bytes(&model.to_bytes()).expect("what is written is read");
        assert_eq!(again.card.kind, model.card.kind);
        let _ = model.sensor();
    }
    let _ = Checkpoint::from_bytes(data, "training");
});
