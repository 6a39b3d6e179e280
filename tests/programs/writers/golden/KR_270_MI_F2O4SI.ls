/PROG  KR_270_MI_F2O4SI
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "elastocal";
PROG_SIZE	= 0;
CREATE		= DATE 00-01-01  TIME 00:00:00;
MODIFIED	= DATE 00-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 123;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Calibration campaign: 4 ;
   2:  !experiments in 3 configurations. ;
   3:  !Made by elastocal 0.1.0 from KR ;
   4:  !270 milling cell. ;
   5:  !plan sha256 0123456789abcdef ;
   6:  !Start: load all of ;
   7:  !KR_270_MI_F2O4SI, select ;
   8:  !KR_270_MI_F2O4SI, run it in T1 ;
   9:  !first. ;
  10:  !Robot: kuka-kr270. Joint values: ;
  11:  !deg, mm, as in the model. ;
  12:  !FANUC arms show J3 as the ;
  13:  !elevation of the forearm, which ;
  14:  !J2 does not change, here it is ;
  15:  !that of the model: if this arm ;
  16:  !does so, say controller: ;
  17:  !(preset: fanuc) in the study ;
  18:  !first. ;
  19:  !Forces act at the load point of ;
  20:  !the tool, in the axes of the ;
  21:  !robot base. ;
  22:  !No home position: the first ;
  23:  !motion starts where the robot ;
  24:  !stands. ;
  25:  !Watched for collisions: floor, ;
  26:  !the robot against itself. ;
  27:  !SAFETY: check this program at ;
  28:  !low speed in manual mode first. ;
  29:  !Motions from point to point were ;
  30:  !checked for collisions with what ;
  31:  !the study names, in this order ;
  32:  !and from home, the way to home ;
  33:  !was not. ;
  34:  !Set the payload of the empty ;
  35:  !calibration tool and leave it ;
  36:  !so, loaded and unloaded: the ;
  37:  !controller must not compensate ;
  38:  !what is to be measured. ;
  39:  !elastocal program 000000000000 ;
  40:  UFRAME_NUM=0 ;
  41:  UTOOL_NUM=1 ;
  42:  !to AP1 ;
  43:J P[1] 10% FINE    ;
  44:  !to P1 ;
  45:J P[2] 10% FINE    ;
  46:  WAIT   2.00(sec) ;
  47:  MESSAGE[Experiment 1/4: pose 1.] ;
  48:  MESSAGE[NO load. Measure M1.] ;
  49:  PAUSE ;
  50:  MESSAGE[Experiment 1/4: hang] ;
  51:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  52:  MESSAGE[-2500 N.] ;
  53:  PAUSE ;
  54:  WAIT   2.00(sec) ;
  55:  MESSAGE[Experiment 1/4: pose 1.] ;
  56:  MESSAGE[LOADED. Measure M1.] ;
  57:  PAUSE ;
  58:  MESSAGE[Experiment 1/4: take the] ;
  59:  MESSAGE[load off. The robot] ;
  60:  MESSAGE[moves next.] ;
  61:  PAUSE ;
  62:  !to AP1 ;
  63:J P[1] 10% FINE    ;
  64:  !to P1 ;
  65:J P[2] 10% FINE    ;
  66:  WAIT   2.00(sec) ;
  67:  MESSAGE[Experiment 2/4: pose 1.] ;
  68:  MESSAGE[NO load. Measure M1.] ;
  69:  PAUSE ;
  70:  MESSAGE[Experiment 2/4: hang] ;
  71:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  72:  MESSAGE[-2500 N.] ;
  73:  PAUSE ;
  74:  WAIT   2.00(sec) ;
  75:  MESSAGE[Experiment 2/4: pose 1.] ;
  76:  MESSAGE[LOADED. Measure M1.] ;
  77:  PAUSE ;
  78:  MESSAGE[Experiment 2/4: take the] ;
  79:  MESSAGE[load off. The robot] ;
  80:  MESSAGE[moves next.] ;
  81:  PAUSE ;
  82:  !to AP2 ;
  83:J P[3] 10% FINE    ;
  84:  !to P2 ;
  85:J P[4] 10% FINE    ;
  86:  WAIT   2.00(sec) ;
  87:  MESSAGE[Experiment 3/4: pose 2.] ;
  88:  MESSAGE[NO load. Measure M1.] ;
  89:  PAUSE ;
  90:  MESSAGE[Experiment 3/4: hang] ;
  91:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  92:  MESSAGE[-2500 N.] ;
  93:  PAUSE ;
  94:  WAIT   2.00(sec) ;
  95:  MESSAGE[Experiment 3/4: pose 2.] ;
  96:  MESSAGE[LOADED. Measure M1.] ;
  97:  PAUSE ;
  98:  MESSAGE[Experiment 3/4: take the] ;
  99:  MESSAGE[load off. The robot] ;
 100:  MESSAGE[moves next.] ;
 101:  PAUSE ;
 102:  !to AP3 ;
 103:J P[5] 10% FINE    ;
 104:  !to P3 ;
 105:J P[6] 10% FINE    ;
 106:  WAIT   2.00(sec) ;
 107:  MESSAGE[Experiment 4/4: pose 3.] ;
 108:  MESSAGE[NO load. Measure M1.] ;
 109:  PAUSE ;
 110:  MESSAGE[Experiment 4/4: hang] ;
 111:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
 112:  MESSAGE[-2500 N.] ;
 113:  PAUSE ;
 114:  WAIT   2.00(sec) ;
 115:  MESSAGE[Experiment 4/4: pose 3.] ;
 116:  MESSAGE[LOADED. Measure M1.] ;
 117:  PAUSE ;
 118:  MESSAGE[Experiment 4/4: take the] ;
 119:  MESSAGE[load off. The robot] ;
 120:  MESSAGE[moves next.] ;
 121:  PAUSE ;
 122:  !to AP3 ;
 123:J P[5] 10% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -51.2922 deg,	J3=   62.5588 deg,
	J4=  -32.0611 deg,	J5=  101.1598 deg,	J6=  -94.2903 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -50.7922 deg,	J3=   63.0588 deg,
	J4=  -32.5611 deg,	J5=  101.6598 deg,	J6=  -93.7903 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -55.9571 deg,	J3=  -72.9034 deg,
	J4= -118.8938 deg,	J5=  -57.0916 deg,	J6= -179.7668 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -55.4571 deg,	J3=  -72.4034 deg,
	J4= -119.3938 deg,	J5=  -56.5916 deg,	J6= -179.2668 deg
};
P[5]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=   -2.1852 deg,	J3=   -4.2994 deg,
	J4=  -57.7496 deg,	J5=   39.0358 deg,	J6=  168.3163 deg
};
P[6]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=   -1.6852 deg,	J3=   -3.7994 deg,
	J4=  -58.2496 deg,	J5=   39.5358 deg,	J6=  168.8163 deg
};
/END
