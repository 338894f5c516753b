//! Tests of study records.

use super::StudyRecord;
use lab::CriterionValues;

#[test]
fn a_record_holds_all_criteria() {
    let record = serde_json::to_value(StudyRecord::new(String::new(), 1)).unwrap();
    assert_eq!(record["criteria"], serde_json::to_value(CriterionValues).unwrap());
}

#[test]
fn a_study_goes_on_from_a_record_without_criteria_or_with_others() {
    let mut record = serde_json::to_value(StudyRecord::new("sum".to_owned(), 7)).unwrap();
    record["criteria"] = serde_json::json!({ "A_CRITERION_OF_AN_OLDER_PROGRAM": 1.0 });
    let other: StudyRecord = serde_json::from_value(record.clone()).unwrap();
    record.as_object_mut().unwrap().remove("criteria");
    let older: StudyRecord = serde_json::from_value(record).unwrap();
    for read in [older, other] {
        assert_eq!((read.seed, read.measurements_sha256.as_str()), (7, "sum"));
        assert_eq!(serde_json::to_value(&read).unwrap()["criteria"], serde_json::to_value(CriterionValues).unwrap());
    }
}
